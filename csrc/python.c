/* The module aoimpact._core: the table of its functions. */
#include "binding.h"

static PyMethodDef methods[] = {
    {"law_force", law_force, METH_VARARGS, NULL},
    {"law_potential", law_potential, METH_VARARGS, NULL},
    {"static_held", static_held, METH_VARARGS, NULL},
    {"static_free", static_free, METH_VARARGS, NULL},
    {"constraint_project", constraint_project, METH_VARARGS, NULL},
    {"constraint_reflector", constraint_reflector, METH_VARARGS, NULL},
    {"constraint_congruence", constraint_congruence, METH_VARARGS, NULL},
    {"oscillators_project", oscillators_project, METH_VARARGS, NULL},
    {"krylov_extend", krylov_extend, METH_VARARGS, NULL},
    {"star_receptance", star_receptance, METH_VARARGS, NULL},
    {"modal_receptance", modal_receptance, METH_VARARGS, NULL},
    {"star_to_modal", star_to_modal, METH_VARARGS, NULL},
    {"star_from_modal", star_from_modal, METH_VARARGS, NULL},
    {"factors_find_panels", factors_find_panels, METH_VARARGS, NULL},
    {"factors_solve", factors_solve, METH_VARARGS, NULL},
    {"newmark_scene", newmark_scene, METH_VARARGS, NULL},
    {"blocks_subtract", blocks_subtract, METH_VARARGS, NULL},
    {"blocks_smooth", blocks_smooth, METH_VARARGS, NULL},
    {"graph_aggregate", graph_aggregate, METH_VARARGS, NULL},
    {"adaptive", adaptive, METH_VARARGS, NULL},
    {"track_sample", track_sample, METH_VARARGS, NULL},
    {"track_forces", track_forces, METH_VARARGS, NULL},
    {"track_states", track_states, METH_VARARGS, NULL},
    {"briefs", briefs, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static PyModuleDef_Slot slots[] = {
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
