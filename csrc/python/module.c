/* The module aoimpact._core: the table of its functions. */
#include "python/binding.h"

#include <fenv.h>

#define FUNCTIONS(X)                                                                              \
    X(law_force) X(law_potential) X(static_constrained) X(static_free) X(constraint_project)      \
    X(constraint_reflector) X(constraint_congruence) X(star_from_constraint_modes)                \
    X(krylov_extend)                                                                              \
    X(star_receptance) X(modal_receptance) X(star_to_modal) X(star_from_modal)                    \
    X(factors_find_panels) X(factors_solve) X(newmark) X(blocks_pattern) X(blocks_multiply) \
    X(blocks_subtract) X(blocks_smooth) X(graph_aggregate) X(adaptive) X(track_open)              \
    X(track_sample) X(track_forces) X(track_states) X(briefs)

/* Of one argument. */
#define FUNCTIONS_OF_ONE(X) X(track_bytes) X(track_rows)

typedef PyObject *function(PyObject *self, PyObject *args);

/* Other libraries leave threads that take subnormal numbers for zero or round another way: the core
 * computes as its tests do, and the thread gets back what it had. */
static PyObject *call_as_tested(function *called, PyObject *self, PyObject *args)
{
    fenv_t before;
    (void)fegetenv(&before);
    (void)fesetenv(FE_DFL_ENV);
    PyObject *result = called(self, args);
    (void)fesetenv(&before);
    return result;
}

#define AS_TESTED(name)                                                                            \
    static PyObject *name##_as_tested(PyObject *self, PyObject *args)                              \
    {                                                                                              \
        return call_as_tested(name, self, args);                                                   \
    }
FUNCTIONS(AS_TESTED)
FUNCTIONS_OF_ONE(AS_TESTED)

#define ENTRY(name) {#name, name##_as_tested, METH_VARARGS, NULL},
#define ENTRY_OF_ONE(name) {#name, name##_as_tested, METH_O, NULL},
static PyMethodDef methods[] = {FUNCTIONS(ENTRY) FUNCTIONS_OF_ONE(ENTRY_OF_ONE){NULL, NULL, 0, NULL}};

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
