/* The star and its modes, for Python. */
#include "python/binding.h"
#include "star/receptance.h"

/* A term of one frequency costs some ten nanoseconds at most. */
static size_t frequencies_a_piece(size_t n)
{
    return 1 + (size_t)(1e8 * SIGNAL_INTERVAL / ((double)n + 1.0));
}

PyObject *star_receptance(PyObject *self, PyObject *args)
{
    PyObject *m_in, *k_in, *omega_in, *out;
    buffer_list buffers = {.failed = 0};
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
    const size_t piece = frequencies_a_piece(star.n);
    for (size_t i = 0; !buffers.failed && i < count && PyErr_CheckSignals() == 0; i += piece) {
        const size_t some = count - i < piece ? count - i : piece;
        Py_BEGIN_ALLOW_THREADS
        aoi_star_receptance(&star, some, omega + i, receptance + i);
        Py_END_ALLOW_THREADS
    }
    return finish(&buffers, AOI_OK, "receptance");
}

PyObject *modal_receptance(PyObject *self, PyObject *args)
{
    PyObject *omega_in, *decay_in, *weight_in, *frequency_in, *real_out, *imaginary_out;
    buffer_list buffers = {.failed = 0};
    double residual;
    size_t n = (size_t)-1, count = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOdOOO", &omega_in, &decay_in, &weight_in, &residual,
                          &frequency_in, &real_out, &imaginary_out)) {
        return NULL;
    }
    const double *omega = doubles(&buffers, omega_in, "omega", &n);
    const double *decay = doubles(&buffers, decay_in, "decay", &n);
    const double *weight = doubles(&buffers, weight_in, "weight", &n);
    const double *frequency = doubles(&buffers, frequency_in, "frequency", &count);
    double *real = doubles_out(&buffers, real_out, "real part", &count);
    double *imaginary = doubles_out(&buffers, imaginary_out, "imaginary part", &count);
    const size_t piece = frequencies_a_piece(n);
    for (size_t i = 0; !buffers.failed && i < count && PyErr_CheckSignals() == 0; i += piece) {
        const size_t some = count - i < piece ? count - i : piece;
        Py_BEGIN_ALLOW_THREADS
        aoi_modal_receptance(n, omega, decay, weight, residual, some, frequency + i, real + i,
                             imaginary + i);
        Py_END_ALLOW_THREADS
    }
    return finish(&buffers, AOI_OK, "receptance");
}

PyObject *star_to_modal(PyObject *self, PyObject *args)
{
    PyObject *m_in, *k_in, *omega2_out, *r_out, *work_out;
    buffer_list buffers = {.failed = 0};
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
    int status = AOI_OK;
    if (!buffers.failed) {
        signal_check signals;
        signal_check_open(&signals);
        signal_check_release(&signals);
        status = aoi_star_to_modal(&star, omega2, r, &modes, work, &signals.pause);
        signal_check_regain(&signals);
    }
    PyObject *done = finish(&buffers, status, "natural modes of a star");
    Py_XDECREF(done);
    return done ? PyLong_FromSize_t(modes) : NULL;
}

PyObject *star_from_modal(PyObject *self, PyObject *args)
{
    PyObject *omega2_in, *weight_in, *m_out, *k_out;
    buffer_list buffers = {.failed = 0};
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
        signal_check signals;
        signal_check_open(&signals);
        signal_check_release(&signals);
        status = aoi_star_from_modal(count, omega2, weight, &m0, &k0, m, k, &signals.pause);
        signal_check_regain(&signals);
    }
    PyObject *done = finish(&buffers, status, "star of a modal model");
    Py_XDECREF(done);
    return done ? Py_BuildValue("dd", m0, k0) : NULL;
}
