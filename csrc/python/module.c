/* The module aoimpact._core: the table of its functions. */
#include "python/binding.h"

#include <fenv.h>

/* The core runs in the default floating-point environment, as in its tests, and the thread's own environment is
 * restored afterwards: some libraries let a thread flush subnormal numbers to zero or round in another mode. */
static PyObject *call_as_tested(PyObject *called(PyObject *args), PyObject *args)
{
    fenv_t before;
    (void)fegetenv(&before);
    (void)fesetenv(FE_DFL_ENV);
    PyObject *result = called(args);
    (void)fesetenv(&before);
    return result;
}

#define AS_TESTED(name)                                                                            \
    static PyObject *name##_as_tested(PyObject *self, PyObject *args)                              \
    {                                                                                              \
        (void)self;                                                                                \
        return call_as_tested(name, args);                                                         \
    }
FUNCTIONS(AS_TESTED)

#define ENTRY(name) {#name, name##_as_tested, METH_VARARGS, NULL},
static PyMethodDef methods[] = {FUNCTIONS(ENTRY){NULL, NULL, 0, NULL}};

#define NAME_OF(part) #part " "
static int add_names(PyObject *module)
{
    return PyModule_AddStringConstant(module, "MODES", MODES_PARTS(NAME_OF));
}

static PyModuleDef_Slot slots[] = {
    {Py_mod_exec, (void *)add_names},
#if !defined(Py_LIMITED_API) && PY_VERSION_HEX >= 0x030D0000
    {Py_mod_multiple_interpreters, Py_MOD_PER_INTERPRETER_GIL_SUPPORTED},
    {Py_mod_gil, Py_MOD_GIL_NOT_USED},
#endif
    {0, NULL},
};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "aoimpact._core", "The C core of aoimpact.", 0, methods, slots,
    NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__core(void) { return PyModuleDef_Init(&definition); }
