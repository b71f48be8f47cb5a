/* From matrices to a star (star/reduce.c), for Python. */
#include "python/binding.h"
#include "star/reduce.h"

PyObject *static_constrained(PyObject *self, PyObject *args)
{
    PyObject *b_in, *x_out;
    buffer_list buffers = {.failed = 0};
    size_t n = (size_t)-1;
    double stiffness = 0.0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OO", &b_in, &x_out)) {
        return NULL;
    }
    const double *b = doubles(&buffers, b_in, "b", &n);
    double *x = doubles_out(&buffers, x_out, "x", &n);
    const int status = buffers.failed ? AOI_OK : aoi_static_constrained(n, b, x, &stiffness);
    PyObject *done = finish(&buffers, status, "static mode");
    Py_XDECREF(done);
    return done ? PyFloat_FromDouble(stiffness) : NULL;
}

PyObject *static_free(PyObject *self, PyObject *args)
{
    PyObject *rigid_in, *b_in, *phi_out;
    buffer_list buffers = {.failed = 0};
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

PyObject *constraint_project(PyObject *self, PyObject *args)
{
    PyObject *b_in, *z_in, *x_out;
    buffer_list buffers = {.failed = 0};
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

PyObject *constraint_reflector(PyObject *self, PyObject *args)
{
    PyObject *b_in, *h_out;
    buffer_list buffers = {.failed = 0};
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

PyObject *constraint_congruence(PyObject *self, PyObject *args)
{
    PyObject *h_in, *a_out, *work_out;
    buffer_list buffers = {.failed = 0};
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

PyObject *star_from_constraint_modes(PyObject *self, PyObject *args)
{
    PyObject *static_in, *m_static_in, *phi_in, *m_phi_in, *omega2_in, *m_out, *k_out, *c_out, *oscillator_out;
    buffer_list buffers = {.failed = 0};
    size_t count = (size_t)-1, n = (size_t)-1;
    aoi_star star = {.n = 0};
    double k0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOdOOOOOOO", &static_in, &m_static_in, &k0, &phi_in, &m_phi_in, &omega2_in, &m_out,
                          &k_out, &c_out, &oscillator_out)) {
        return NULL;
    }
    const double *phi_st = doubles(&buffers, static_in, "phi_st", &n);
    const double *m_phi_st = doubles(&buffers, m_static_in, "M phi_st", &n);
    const double *omega2 = doubles(&buffers, omega2_in, "omega2", &count);
    size_t all = n * count;
    const double *phi = doubles(&buffers, phi_in, "phi", &all);
    const double *m_phi = doubles(&buffers, m_phi_in, "M phi", &all);
    double *m = doubles_out(&buffers, m_out, "m", &count);
    double *k = doubles_out(&buffers, k_out, "k", &count);
    double *c = doubles_out(&buffers, c_out, "c", &count);
    int32_t *oscillator = buffers_take(&buffers, oscillator_out, "oscillator", 'i', 1, &count);
    int status = AOI_OK;
    if (!buffers.failed) {
        Py_BEGIN_ALLOW_THREADS
        status = aoi_star_from_constraint_modes(n, count, phi_st, m_phi_st, k0, phi, m_phi, omega2, &star, m, k, c,
                                                oscillator);
        Py_END_ALLOW_THREADS
    }
    PyObject *done = finish(&buffers, status, "anti-oscillators");
    Py_XDECREF(done);
    return done ? Py_BuildValue("nd", (Py_ssize_t)star.n, star.m0) : NULL;
}
