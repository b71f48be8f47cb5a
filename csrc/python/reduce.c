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

PyObject *oscillators_project(PyObject *self, PyObject *args)
{
    PyObject *phi_in, *modal_in, *omega2_in, *static_in, *c_out, *m_out, *k_out;
    buffer_list buffers = {.failed = 0};
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
