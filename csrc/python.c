/* The core seen from Python: buffers in, buffers out, nothing of the method. Only this file includes
 * Python.h. Arrays come as C-contiguous buffers of float64 or int32, made so by the Python side;
 * results are written into buffers that the caller made. The GIL is released in chunks of some
 * milliseconds, so that other threads run and Ctrl-C is heard. */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "aoimpact.h"

#include <stdlib.h>

/* ------------------------------------------------------------------------------------ buffers */

enum { MOST_BUFFERS = 40 };

/* The buffers that one call holds; after the first failure the others are not taken. */
typedef struct held {
    Py_buffer view[MOST_BUFFERS];
    int count, failed;
} held;

static void held_release(held *buffers)
{
    for (int i = 0; i < buffers->count; i++) {
        PyBuffer_Release(&buffers->view[i]);
    }
    buffers->count = 0;
}

static void *held_take(held *buffers, PyObject *object, const char *name, char type, int writable,
                       size_t *count)
{
    const Py_ssize_t size = type == 'd' ? (Py_ssize_t)sizeof(double) : (Py_ssize_t)sizeof(int32_t);
    Py_buffer *view = &buffers->view[buffers->count];
    if (buffers->failed) {
        return NULL;
    }
    buffers->failed = 1;
    if (PyErr_Occurred()) {
        return NULL; /* from the conversion of a number before */
    }
    if (buffers->count == MOST_BUFFERS) {
        PyErr_SetString(PyExc_SystemError, "a call with more buffers than it can hold");
        return NULL;
    }
    if (PyObject_GetBuffer(object, view,
                           PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (writable ? PyBUF_WRITABLE : 0)) != 0) {
        return NULL;
    }
    buffers->count++;
    const char code = view->format ? view->format[0] : 'B';
    if (view->itemsize != size || (type == 'd' ? code != 'd' : code != 'i' && code != 'l')) {
        PyErr_Format(PyExc_TypeError, "%s must be a C-contiguous buffer of %s, not of format '%s'",
                     name, type == 'd' ? "float64" : "int32", view->format ? view->format : "B");
        return NULL;
    }
    buffers->failed = 0;
    const size_t length = (size_t)(view->len / size);
    if (*count == (size_t)-1) {
        *count = length;
    } else if (*count != length) {
        buffers->failed = 1;
        PyErr_Format(PyExc_ValueError, "%s must hold %zu values, not %zu", name, *count, length);
        return NULL;
    }
    return view->buf;
}

/* In these, count is what the buffer must hold; -1 takes what comes and says it. */
static const double *doubles(held *buffers, PyObject *object, const char *name, size_t *count)
{
    return held_take(buffers, object, name, 'd', 0, count);
}

static double *doubles_out(held *buffers, PyObject *object, const char *name, size_t *count)
{
    return held_take(buffers, object, name, 'd', 1, count);
}

static const int32_t *integers(held *buffers, PyObject *object, const char *name, size_t *count)
{
    return held_take(buffers, object, name, 'i', 0, count);
}

/* ------------------------------------------------------------------------------------- errors */

/* Raises what aoimpact.errors makes of a status: the one table of the core's codes stands there. */
static PyObject *raise_status(int status, const char *what, double time)
{
    PyObject *module = PyImport_ImportModule("aoimpact.errors");
    PyObject *error =
        module ? PyObject_CallMethod(module, "core_error", "isd", status, what, time) : NULL;
    if (error) {
        PyErr_SetObject((PyObject *)Py_TYPE(error), error);
    }
    Py_XDECREF(error);
    Py_XDECREF(module);
    return NULL;
}

static PyObject *finish(held *buffers, int status, const char *what)
{
    held_release(buffers);
    if (buffers->failed) {
        return NULL;
    }
    if (status != AOI_OK) {
        return raise_status(status, what, -1.0);
    }
    Py_RETURN_NONE;
}

/* --------------------------------------------------------------------------------------- laws */

static int take_law(held *buffers, const char *name, PyObject *parameter, aoi_law *law)
{
    size_t count = (size_t)-1;
    const double *values = doubles(buffers, parameter, "law parameters", &count);
    return buffers->failed ? AOI_OK : aoi_law_create(law, name, count, values);
}

static PyObject *law_force(PyObject *self, PyObject *args)
{
    const char *name;
    PyObject *parameter, *indentation_in, *rate_in, *force_out, *stiffness_out, *damping_out;
    held buffers = {.count = 0};
    size_t n = (size_t)-1;
    aoi_law law;
    (void)self;
    if (!PyArg_ParseTuple(args, "sOOOOOO", &name, &parameter, &indentation_in, &rate_in, &force_out,
                          &stiffness_out, &damping_out)) {
        return NULL;
    }
    const int status = take_law(&buffers, name, parameter, &law);
    const double *indentation = doubles(&buffers, indentation_in, "indentation", &n);
    const double *rate = doubles(&buffers, rate_in, "rate", &n);
    double *force = doubles_out(&buffers, force_out, "force", &n);
    double *stiffness = doubles_out(&buffers, stiffness_out, "stiffness", &n);
    double *damping = doubles_out(&buffers, damping_out, "damping", &n);
    for (size_t i = 0; !buffers.failed && status == AOI_OK && i < n; i++) {
        aoi_law_value value;
        law.force(&law, indentation[i], rate[i], &value);
        force[i] = value.force;
        stiffness[i] = value.stiffness;
        damping[i] = value.damping;
    }
    return finish(&buffers, status, "contact law");
}

static PyObject *law_potential(PyObject *self, PyObject *args)
{
    const char *name;
    PyObject *parameter, *indentation_in, *energy_out;
    held buffers = {.count = 0};
    size_t n = (size_t)-1;
    aoi_law law;
    (void)self;
    if (!PyArg_ParseTuple(args, "sOOO", &name, &parameter, &indentation_in, &energy_out)) {
        return NULL;
    }
    const int status = take_law(&buffers, name, parameter, &law);
    const double *indentation = doubles(&buffers, indentation_in, "indentation", &n);
    double *energy = doubles_out(&buffers, energy_out, "energy", &n);
    for (size_t i = 0; !buffers.failed && status == AOI_OK && i < n; i++) {
        energy[i] = law.potential(&law, indentation[i]);
    }
    return finish(&buffers, status, "contact law");
}

/* ---------------------------------------------------------------------------------- reduction */

static PyObject *static_held(PyObject *self, PyObject *args)
{
    PyObject *b_in, *x_out;
    held buffers = {.count = 0};
    size_t n = (size_t)-1;
    double stiffness = 0.0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OO", &b_in, &x_out)) {
        return NULL;
    }
    const double *b = doubles(&buffers, b_in, "b", &n);
    double *x = doubles_out(&buffers, x_out, "x", &n);
    const int status = buffers.failed ? AOI_OK : aoi_static_held(n, b, x, &stiffness);
    PyObject *done = finish(&buffers, status, "static mode");
    Py_XDECREF(done);
    return done ? PyFloat_FromDouble(stiffness) : NULL;
}

static PyObject *static_free(PyObject *self, PyObject *args)
{
    PyObject *rigid_in, *b_in, *phi_out;
    held buffers = {.count = 0};
    size_t n = (size_t)-1, all = (size_t)-1;
    double mass = 0.0;
    int status = AOI_OK;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &rigid_in, &b_in, &phi_out)) {
        return NULL;
    }
    const double *b = doubles(&buffers, b_in, "b", &n);
    double *phi = doubles_out(&buffers, phi_out, "phi_st", &n);
    const double *rigid = doubles(&buffers, rigid_in, "rigid modes", &all);
    if (!buffers.failed) {
        status = n > 0 && all % n == 0 ? aoi_static_free(n, all / n, rigid, b, phi, &mass)
                                       : AOI_ERROR_ARGUMENT;
    }
    PyObject *done = finish(&buffers, status, "static mode");
    Py_XDECREF(done);
    return done ? PyFloat_FromDouble(mass) : NULL;
}

static PyObject *constraint_project(PyObject *self, PyObject *args)
{
    PyObject *b_in, *z_in, *x_out;
    held buffers = {.count = 0};
    size_t n = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &b_in, &z_in, &x_out)) {
        return NULL;
    }
    const double *b = doubles(&buffers, b_in, "b", &n);
    const double *z = doubles(&buffers, z_in, "z", &n);
    double *x = doubles_out(&buffers, x_out, "x", &n);
    const int status = buffers.failed ? AOI_OK : aoi_constraint_project(n, b, z, x);
    return finish(&buffers, status, "constraint modes");
}

static PyObject *constraint_reflector(PyObject *self, PyObject *args)
{
    PyObject *b_in, *h_out;
    held buffers = {.count = 0};
    size_t n = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "OO", &b_in, &h_out)) {
        return NULL;
    }
    const double *b = doubles(&buffers, b_in, "b", &n);
    double *h = doubles_out(&buffers, h_out, "h", &n);
    const int status = buffers.failed ? AOI_OK : aoi_constraint_reflector(n, b, h);
    return finish(&buffers, status, "constraint modes");
}

static PyObject *constraint_congruence(PyObject *self, PyObject *args)
{
    PyObject *h_in, *a_out, *work_out;
    held buffers = {.count = 0};
    size_t n = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &h_in, &a_out, &work_out)) {
        return NULL;
    }
    const double *h = doubles(&buffers, h_in, "h", &n);
    size_t square = n * n;
    double *a = doubles_out(&buffers, a_out, "a", &square);
    double *work = doubles_out(&buffers, work_out, "work", &n);
    if (!buffers.failed) {
        Py_BEGIN_ALLOW_THREADS
        aoi_constraint_congruence(n, h, a, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&buffers, AOI_OK, "constraint modes");
}

static PyObject *oscillators_project(PyObject *self, PyObject *args)
{
    PyObject *phi_in, *modal_in, *omega2_in, *static_in, *c_out, *m_out, *k_out;
    held buffers = {.count = 0};
    size_t count = (size_t)-1, n = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOOO", &phi_in, &modal_in, &omega2_in, &static_in, &c_out, &m_out,
                          &k_out)) {
        return NULL;
    }
    const double *modal = doubles(&buffers, modal_in, "modal masses", &count);
    const double *m_phi_st = doubles(&buffers, static_in, "M phi_st", &n);
    size_t all = n * count;
    const double *phi = doubles(&buffers, phi_in, "phi", &all);
    const double *omega2 = doubles(&buffers, omega2_in, "omega2", &count);
    double *c = doubles_out(&buffers, c_out, "c", &count);
    double *m = doubles_out(&buffers, m_out, "m", &count);
    double *k = doubles_out(&buffers, k_out, "k", &count);
    const int status =
        buffers.failed
            ? AOI_OK
            : aoi_oscillators_project(n, count, phi, modal, omega2, m_phi_st, c, m, k);
    return finish(&buffers, status, "anti-oscillators");
}

/* --------------------------------------------------------------------------------------- star */

static PyObject *star_receptance(PyObject *self, PyObject *args)
{
    PyObject *m_in, *k_in, *omega_in, *out;
    held buffers = {.count = 0};
    aoi_star star = {.n = (size_t)-1};
    size_t count = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "ddOOOO", &star.m0, &star.k0, &m_in, &k_in, &omega_in, &out)) {
        return NULL;
    }
    star.m = doubles(&buffers, m_in, "m", &star.n);
    star.k = doubles(&buffers, k_in, "k", &star.n);
    const double *omega = doubles(&buffers, omega_in, "omega", &count);
    double *receptance = doubles_out(&buffers, out, "receptance", &count);
    if (!buffers.failed) {
        aoi_star_receptance(&star, count, omega, receptance);
    }
    return finish(&buffers, AOI_OK, "receptance");
}

static PyObject *star_to_modal(PyObject *self, PyObject *args)
{
    PyObject *m_in, *k_in, *omega2_out, *r_out, *work_out;
    held buffers = {.count = 0};
    aoi_star star = {.n = (size_t)-1};
    size_t modes = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "ddOOOOO", &star.m0, &star.k0, &m_in, &k_in, &omega2_out, &r_out,
                          &work_out)) {
        return NULL;
    }
    star.m = doubles(&buffers, m_in, "m", &star.n);
    star.k = doubles(&buffers, k_in, "k", &star.n);
    size_t most = star.n + 1;
    double *omega2 = doubles_out(&buffers, omega2_out, "omega2", &most);
    double *r = doubles_out(&buffers, r_out, "participation", &most);
    double *work = doubles_out(&buffers, work_out, "work", &star.n);
    const int status =
        buffers.failed ? AOI_OK : aoi_star_to_modal(&star, omega2, r, &modes, work);
    PyObject *done = finish(&buffers, status, "natural modes of a star");
    Py_XDECREF(done);
    return done ? PyLong_FromSize_t(modes) : NULL;
}

static PyObject *star_from_modal(PyObject *self, PyObject *args)
{
    PyObject *omega2_in, *weight_in, *m_out, *k_out;
    held buffers = {.count = 0};
    size_t count = (size_t)-1;
    double m0 = 0.0, k0 = 0.0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOO", &omega2_in, &weight_in, &m_out, &k_out)) {
        return NULL;
    }
    const double *omega2 = doubles(&buffers, omega2_in, "omega2", &count);
    const double *weight = doubles(&buffers, weight_in, "weight", &count);
    size_t oscillators = count > 0 ? count - 1 : 0;
    double *m = doubles_out(&buffers, m_out, "m", &oscillators);
    double *k = doubles_out(&buffers, k_out, "k", &oscillators);
    int status = AOI_OK;
    if (!buffers.failed) {
        Py_BEGIN_ALLOW_THREADS
        status = aoi_star_from_modal(count, omega2, weight, &m0, &k0, m, k);
        Py_END_ALLOW_THREADS
    }
    PyObject *done = finish(&buffers, status, "star of a modal model");
    Py_XDECREF(done);
    return done ? Py_BuildValue("dd", m0, k0) : NULL;
}

/* ----------------------------------------------------------------------- factors and matrices */

static void need_tuple(held *buffers, PyObject *tuple, Py_ssize_t size)
{
    if (!buffers->failed && (!PyTuple_Check(tuple) || PyTuple_Size(tuple) != size)) {
        buffers->failed = 1;
        PyErr_Format(PyExc_TypeError, "a tuple of %zd buffers is needed here", size);
    }
}

/* (start, indices, values) of a matrix of n rows. */
static int take_sparse(held *buffers, PyObject *tuple, size_t n, aoi_sparse *matrix)
{
    size_t rows = n + 1, stored = (size_t)-1;
    need_tuple(buffers, tuple, 3);
    if (buffers->failed) {
        return AOI_OK;
    }
    matrix->n = n;
    matrix->start = integers(buffers, PyTuple_GetItem(tuple, 0), "row starts", &rows);
    matrix->values = doubles(buffers, PyTuple_GetItem(tuple, 2), "values", &stored);
    matrix->indices = integers(buffers, PyTuple_GetItem(tuple, 1), "indices", &stored);
    return buffers->failed ? AOI_OK : aoi_sparse_check(matrix, stored);
}

/* (start, rows, values, pivots, place, panel). */
static int take_factors(held *buffers, PyObject *tuple, size_t n, aoi_factors *factors)
{
    size_t columns = n + 1, stored = (size_t)-1, panels = (size_t)-1;
    need_tuple(buffers, tuple, 6);
    if (buffers->failed) {
        return AOI_OK;
    }
    factors->n = n;
    factors->start = integers(buffers, PyTuple_GetItem(tuple, 0), "column starts", &columns);
    factors->values = doubles(buffers, PyTuple_GetItem(tuple, 2), "factor values", &stored);
    factors->rows = integers(buffers, PyTuple_GetItem(tuple, 1), "factor rows", &stored);
    factors->pivots = doubles(buffers, PyTuple_GetItem(tuple, 3), "pivots", &n);
    factors->place = integers(buffers, PyTuple_GetItem(tuple, 4), "place", &n);
    factors->panel = integers(buffers, PyTuple_GetItem(tuple, 5), "panels", &panels);
    factors->panel_count = panels - 1;
    if (!buffers->failed && panels < 1) {
        return AOI_ERROR_ARGUMENT;
    }
    return buffers->failed ? AOI_OK : aoi_factors_check(factors, stored);
}

static PyObject *factors_find_panels(PyObject *self, PyObject *args)
{
    PyObject *start_in, *rows_in, *panel_out;
    held buffers = {.count = 0};
    size_t columns = (size_t)-1, stored = (size_t)-1, count = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &start_in, &rows_in, &panel_out)) {
        return NULL;
    }
    const int32_t *start = integers(&buffers, start_in, "column starts", &columns);
    const int32_t *rows = integers(&buffers, rows_in, "factor rows", &stored);
    int32_t *panel = held_take(&buffers, panel_out, "panels", 'i', 1, &columns);
    int status = AOI_OK;
    if (!buffers.failed) {
        const aoi_sparse pattern = {columns > 0 ? columns - 1 : 0, start, rows, NULL};
        status = columns > 0 ? aoi_sparse_check(&pattern, stored) : AOI_ERROR_ARGUMENT;
        count = status == AOI_OK ? aoi_factors_find_panels(pattern.n, start, rows, panel) : 0;
    }
    PyObject *done = finish(&buffers, status, "factors");
    Py_XDECREF(done);
    return done ? PyLong_FromSize_t(count) : NULL;
}

static PyObject *factors_solve(PyObject *self, PyObject *args)
{
    PyObject *factors_in, *work_out, *x_out;
    held buffers = {.count = 0};
    aoi_factors factors = {.n = 0};
    size_t n = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!OO", &PyTuple_Type, &factors_in, &work_out, &x_out)) {
        return NULL;
    }
    double *x = doubles_out(&buffers, x_out, "x", &n);
    int status = take_factors(&buffers, factors_in, n, &factors);
    factors.work = doubles_out(&buffers, work_out, "work", &n);
    if (!buffers.failed && status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        status = aoi_factors_solve(&factors, x);
        Py_END_ALLOW_THREADS
    }
    return finish(&buffers, status, "back-substitution");
}

/* ------------------------------------------------------------------------------------- impact */

/* One body of an impact with all that it needs to live. */
typedef struct player {
    aoi_body body;
    aoi_star star;
    aoi_full full;
    aoi_factors factors;
    double *u, *v; /* initial values in, final values out */
    size_t coordinates;
    double *work;
    double step_cost; /* rough nanoseconds */
} player;

/* ("star", m0, k0, m, k, centre, u, v) */
static int take_star(held *buffers, PyObject *tuple, player *one, const aoi_newmark *rule)
{
    size_t n = (size_t)-1;
    one->star.m0 = PyFloat_AsDouble(PyTuple_GetItem(tuple, 1));
    one->star.k0 = PyFloat_AsDouble(PyTuple_GetItem(tuple, 2));
    one->star.m = doubles(buffers, PyTuple_GetItem(tuple, 3), "m", &n);
    one->star.k = doubles(buffers, PyTuple_GetItem(tuple, 4), "k", &n);
    one->star.n = n;
    one->coordinates = n + 1;
    const double *centre =
        doubles(buffers, PyTuple_GetItem(tuple, 5), "centre", &one->coordinates);
    one->u = doubles_out(buffers, PyTuple_GetItem(tuple, 6), "u", &one->coordinates);
    one->v = doubles_out(buffers, PyTuple_GetItem(tuple, 7), "v", &one->coordinates);
    one->step_cost = 40.0 + 4.0 * (double)n;
    if (buffers->failed) {
        return AOI_OK;
    }
    one->work = malloc(aoi_body_star_size(n) * sizeof(double));
    if (!one->work) {
        buffers->failed = 1;
        PyErr_NoMemory();
        return AOI_OK;
    }
    return aoi_body_start_star(&one->body, &one->star, rule, centre, one->u, one->v, one->work);
}

/* ("full", K, M, b, factors, centre, u, v) */
static int take_full(held *buffers, PyObject *tuple, player *one, const aoi_newmark *rule)
{
    size_t n = (size_t)-1;
    const double *b = doubles(buffers, PyTuple_GetItem(tuple, 3), "b", &n);
    if (buffers->failed) {
        return AOI_OK;
    }
    int status = take_sparse(buffers, PyTuple_GetItem(tuple, 1), n, &one->full.K);
    if (status == AOI_OK) {
        status = take_sparse(buffers, PyTuple_GetItem(tuple, 2), n, &one->full.M);
    }
    if (status == AOI_OK) {
        status = take_factors(buffers, PyTuple_GetItem(tuple, 4), n, &one->factors);
    }
    const double *centre = doubles(buffers, PyTuple_GetItem(tuple, 5), "centre", &n);
    one->u = doubles_out(buffers, PyTuple_GetItem(tuple, 6), "u", &n);
    one->v = doubles_out(buffers, PyTuple_GetItem(tuple, 7), "v", &n);
    one->coordinates = n;
    if (buffers->failed || status != AOI_OK) {
        return status;
    }
    one->step_cost = 2.0 * (3.0 * one->full.K.start[n] + 2.0 * one->factors.start[n]);
    one->work = malloc((aoi_body_full_size(n) + n) * sizeof(double));
    if (!one->work) {
        buffers->failed = 1;
        PyErr_NoMemory();
        return AOI_OK;
    }
    one->factors.work = one->work + aoi_body_full_size(n);
    one->full.b = b;
    one->full.solver = (aoi_solver){aoi_factors_solve, &one->factors};
    return aoi_body_start_full(&one->body, &one->full, rule, centre, one->u, one->v, one->work);
}

static int is_kind(PyObject *tuple, const char *kind)
{
    PyObject *first = PyTuple_GetItem(tuple, 0);
    return PyUnicode_Check(first) && PyUnicode_CompareWithASCIIString(first, kind) == 0;
}

static int take_player(held *buffers, PyObject *tuple, player *one, const aoi_newmark *rule)
{
    need_tuple(buffers, tuple, 8);
    if (buffers->failed) {
        return AOI_OK;
    }
    if (is_kind(tuple, "star")) {
        return take_star(buffers, tuple, one, rule);
    }
    if (is_kind(tuple, "full")) {
        return take_full(buffers, tuple, one, rule);
    }
    buffers->failed = 1;
    PyErr_SetString(PyExc_TypeError, "a body is a tuple that begins with \"star\" or \"full\"");
    return AOI_OK;
}

/* Runs the steps in chunks without the GIL; between them signals are heard. */
static int run_in_chunks(aoi_impact *impact, double *const *row, size_t steps, double step_cost,
                         size_t *done)
{
    const double in_20_ms = 2e7 / step_cost;
    const size_t chunk = in_20_ms < 1.0 ? 1 : (size_t)in_20_ms;
    *done = 0;
    int status = aoi_impact_start(impact, row);
    while (status == AOI_OK && *done < steps) {
        const size_t first = *done + 1;
        const size_t last = steps - *done < chunk ? steps : *done + chunk;
        Py_BEGIN_ALLOW_THREADS
        status = aoi_impact_run(impact, row, first, last, done);
        Py_END_ALLOW_THREADS
        if (PyErr_CheckSignals() != 0) {
            break;
        }
    }
    return status;
}

static void give_back(player *one, int copy)
{
    if (copy) {
        one->body.copy_state(&one->body, one->u, one->v);
    }
    free(one->work);
}

static PyObject *impact(PyObject *self, PyObject *args)
{
    PyObject *projectile_in, *target_in, *parameter, *record_out;
    const char *law_name;
    held buffers = {.count = 0};
    player projectile = {.work = NULL}, target = {.work = NULL};
    aoi_newmark rule;
    aoi_law law;
    double gap;
    int energies;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!sOddddOp", &PyTuple_Type, &projectile_in, &PyTuple_Type,
                          &target_in, &law_name, &parameter, &gap, &rule.dt, &rule.beta, &rule.gamma,
                          &record_out, &energies)) {
        return NULL;
    }
    size_t values = (size_t)-1, done = 0;
    double *record = doubles_out(&buffers, record_out, "record", &values);
    int status = take_law(&buffers, law_name, parameter, &law);
    if (status == AOI_OK) {
        status = take_player(&buffers, projectile_in, &projectile, &rule);
    }
    if (status == AOI_OK) {
        status = take_player(&buffers, target_in, &target, &rule);
    }
    if (!buffers.failed && (values % AOI_ROW_COUNT != 0 || values < AOI_ROW_COUNT)) {
        status = AOI_ERROR_ARGUMENT;
    }
    if (!buffers.failed && status == AOI_OK) {
        const size_t columns = values / AOI_ROW_COUNT;
        double *row[AOI_ROW_COUNT];
        for (size_t i = 0; i < AOI_ROW_COUNT; i++) {
            const size_t of_body = i < AOI_ROW_BODY ? 0 : (i - AOI_ROW_BODY) % AOI_ROW_BODY_COUNT;
            const int is_energy = i == AOI_ROW_CONTACT_ENERGY || of_body >= 4;
            row[i] = is_energy && !energies ? NULL : record + i * columns;
        }
        aoi_impact pair = {&projectile.body, &target.body, &law, gap, 0.0, 0.0};
        status = run_in_chunks(&pair, row, columns - 1,
                               projectile.step_cost + target.step_cost, &done);
    }
    const int finished = !buffers.failed && status == AOI_OK && !PyErr_Occurred();
    give_back(&projectile, finished);
    give_back(&target, finished);
    held_release(&buffers);
    if (buffers.failed || PyErr_Occurred()) {
        return NULL;
    }
    if (status != AOI_OK) {
        return raise_status(status, "Newmark step", rule.dt * (double)(done + 1));
    }
    Py_RETURN_NONE;
}

/* ----------------------------------------------------------------------------- adaptive run */

/* (omega, weight, load, projectile's modes, residuals (2), gap) */
static void take_relative(held *buffers, PyObject *tuple, aoi_relative *relative)
{
    size_t n = (size_t)-1, two = 2;
    need_tuple(buffers, tuple, 6);
    if (buffers->failed) {
        return;
    }
    relative->omega = doubles(buffers, PyTuple_GetItem(tuple, 0), "omega", &n);
    relative->weight = doubles(buffers, PyTuple_GetItem(tuple, 1), "weight", &n);
    relative->load = doubles(buffers, PyTuple_GetItem(tuple, 2), "load", &n);
    const double *residual = doubles(buffers, PyTuple_GetItem(tuple, 4), "residual", &two);
    if (buffers->failed) {
        return;
    }
    relative->n = n;
    relative->n_projectile = PyLong_AsSize_t(PyTuple_GetItem(tuple, 3));
    relative->gap = PyFloat_AsDouble(PyTuple_GetItem(tuple, 5));
    relative->residual[0] = residual[0];
    relative->residual[1] = residual[1];
    if (!PyErr_Occurred() && relative->n_projectile > n) {
        PyErr_SetString(PyExc_ValueError, "more modes of the projectile than modes");
    }
    buffers->failed = PyErr_Occurred() != NULL;
}

/* A track that grows as the run goes on. */
typedef struct growing {
    double *rows;
    size_t count, capacity, width;
} growing;

static const size_t MOST_BYTES = (size_t)1 << 30;

static int grow(growing *track)
{
    const size_t capacity = track->capacity ? 2 * track->capacity : 64;
    double *rows = realloc(track->rows, capacity * track->width * sizeof(double));
    if (!rows) {
        PyErr_NoMemory();
        return 0;
    }
    track->rows = rows;
    track->capacity = capacity;
    return 1;
}

/* Runs without the GIL, in pieces between which signals are heard. */
static int run_to_end(aoi_adaptive *run, growing *track)
{
    /* A row costs some 0.2 us a mode: pieces of a tenth of a second at most. */
    const size_t between_signals = 1 + 400000 / (run->relative->n + 100);
    int status = aoi_adaptive_start(run);
    while (status == AOI_OK && run->time < run->end) {
        size_t written = 0;
        if (track->count * track->width * sizeof(double) > MOST_BYTES) {
            return AOI_ERROR_TOO_LONG;
        }
        if (track->count == track->capacity && !grow(track)) {
            break;
        }
        const size_t left = track->capacity - track->count;
        const size_t piece = left < between_signals ? left : between_signals;
        Py_BEGIN_ALLOW_THREADS
        status = aoi_adaptive_run(run, piece, track->rows + track->count * track->width, &written);
        Py_END_ALLOW_THREADS
        track->count += written;
        if (PyErr_CheckSignals() != 0) {
            break;
        }
    }
    return status;
}

/* order of the modes by omega: insertion, since each body's are in order already. */
static void sort_by_omega(const aoi_relative *relative, size_t *order)
{
    for (size_t i = 0; i < relative->n; i++) {
        size_t j = i;
        for (; j > 0 && relative->omega[order[j - 1]] > relative->omega[i]; j--) {
            order[j] = order[j - 1];
        }
        order[j] = i;
    }
}

static PyObject *adaptive_result(const aoi_adaptive *run, const growing *track)
{
    return Py_BuildValue("y#ndddnn", (const char *)track->rows,
                         (Py_ssize_t)(track->count * track->width * sizeof(double)),
                         (Py_ssize_t)track->count, run->peak_force, run->peak_time, run->impulse,
                         (Py_ssize_t)run->steps, (Py_ssize_t)run->rejected);
}

static PyObject *adaptive(PyObject *self, PyObject *args)
{
    PyObject *relative_in, *parameter, *x_out, *v_out, *result = NULL;
    const char *law_name;
    held buffers = {.count = 0};
    aoi_relative relative = {.n = 0};
    aoi_law law;
    aoi_adaptive run = {.relative = &relative, .law = &law};
    (void)self;
    if (!PyArg_ParseTuple(args, "O!sOddOO", &PyTuple_Type, &relative_in, &law_name, &parameter,
                          &run.rtol, &run.end, &x_out, &v_out)) {
        return NULL;
    }
    take_relative(&buffers, relative_in, &relative);
    int status = buffers.failed ? AOI_OK : take_law(&buffers, law_name, parameter, &law);
    size_t n = relative.n;
    run.x = buffers.failed ? NULL : doubles_out(&buffers, x_out, "x", &n);
    run.v = buffers.failed ? NULL : doubles_out(&buffers, v_out, "v", &n);
    growing track = {NULL, 0, 0, AOI_TRACK_FIXED + 2 * n};
    if (!buffers.failed && status == AOI_OK) {
        size_t *order = malloc((n + 1) * sizeof *order);
        run.block = malloc((AOI_TABLES * aoi_collocation_size(n) + 1) * sizeof(double));
        run.order = order;
        if (order && run.block) {
            sort_by_omega(&relative, order);
            status = run_to_end(&run, &track);
        } else {
            PyErr_NoMemory();
        }
        free(order);
        free(run.block);
    }
    held_release(&buffers);
    if (!buffers.failed && !PyErr_Occurred()) {
        result = status == AOI_OK ? adaptive_result(&run, &track)
                                  : raise_status(status, "adaptive run", run.time);
    }
    free(track.rows);
    return result;
}

static PyObject *track_sample(PyObject *self, PyObject *args)
{
    PyObject *relative_in, *parameter, *centre_in, *centre_residual_in, *track_in, *times_in;
    PyObject *record_out;
    const char *law_name;
    held buffers = {.count = 0};
    aoi_relative relative = {.n = 0};
    aoi_law law;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!sOOOOOO", &PyTuple_Type, &relative_in, &law_name, &parameter,
                          &centre_in, &centre_residual_in, &track_in, &times_in, &record_out)) {
        return NULL;
    }
    size_t values = (size_t)-1, count = (size_t)-1, two = 2;
    take_relative(&buffers, relative_in, &relative);
    int status = buffers.failed ? AOI_OK : take_law(&buffers, law_name, parameter, &law);
    size_t n = relative.n;
    aoi_centres centres = {NULL, {0.0, 0.0}};
    centres.weight = doubles(&buffers, centre_in, "centre", &n);
    const double *residual = doubles(&buffers, centre_residual_in, "centre residual", &two);
    const double *track = doubles(&buffers, track_in, "track", &values);
    const double *times = doubles(&buffers, times_in, "times", &count);
    size_t wanted = AOI_ROW_COUNT * (count == (size_t)-1 ? 0 : count);
    double *record = doubles_out(&buffers, record_out, "record", &wanted);
    double *work = buffers.failed ? NULL : malloc((2 * n + 1) * sizeof(double));
    if (work && status == AOI_OK) {
        double *row[AOI_ROW_COUNT];
        for (size_t i = 0; i < AOI_ROW_COUNT; i++) {
            row[i] = record + i * count;
        }
        centres.residual[0] = residual[0];
        centres.residual[1] = residual[1];
        const size_t width = AOI_TRACK_FIXED + 2 * n;
        const size_t rows = values % width == 0 ? values / width : 0;
        Py_BEGIN_ALLOW_THREADS
        status = aoi_track_sample(&relative, &law, &centres, rows, track, count, times, row, work);
        Py_END_ALLOW_THREADS
    } else if (!buffers.failed && !work) {
        PyErr_NoMemory();
    }
    free(work);
    PyObject *done = finish(&buffers, status, "dense output");
    if (done && PyErr_Occurred()) {
        Py_DECREF(done);
        return NULL;
    }
    return done;
}

static PyObject *record_rows(PyObject *self, PyObject *none)
{
    (void)self;
    (void)none;
    return PyLong_FromLong(AOI_ROW_COUNT);
}

/* ------------------------------------------------------------------------------------- module */

static PyMethodDef methods[] = {
    {"law_force", law_force, METH_VARARGS, NULL},
    {"law_potential", law_potential, METH_VARARGS, NULL},
    {"static_held", static_held, METH_VARARGS, NULL},
    {"static_free", static_free, METH_VARARGS, NULL},
    {"constraint_project", constraint_project, METH_VARARGS, NULL},
    {"constraint_reflector", constraint_reflector, METH_VARARGS, NULL},
    {"constraint_congruence", constraint_congruence, METH_VARARGS, NULL},
    {"oscillators_project", oscillators_project, METH_VARARGS, NULL},
    {"star_receptance", star_receptance, METH_VARARGS, NULL},
    {"star_to_modal", star_to_modal, METH_VARARGS, NULL},
    {"star_from_modal", star_from_modal, METH_VARARGS, NULL},
    {"factors_find_panels", factors_find_panels, METH_VARARGS, NULL},
    {"factors_solve", factors_solve, METH_VARARGS, NULL},
    {"impact", impact, METH_VARARGS, NULL},
    {"adaptive", adaptive, METH_VARARGS, NULL},
    {"track_sample", track_sample, METH_VARARGS, NULL},
    {"record_rows", record_rows, METH_NOARGS, NULL},
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
