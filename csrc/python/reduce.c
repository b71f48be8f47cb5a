/* From matrices to a star (star/reduce.c), for Python. */
#include "python/binding.h"
#include "star/reduce.h"

PyObject *static_constrained(PyObject *args)
{
    call of = {.status = AOI_OK};
    size_t n = ANY_LENGTH;
    const double *b;
    double *x, stiffness = 0.0;
    TAKE(&of, args, ARRAY('d', b, n), ARRAY('D', x, n));
    if (of.status == AOI_OK) {
        of.status = aoi_static_constrained(n, b, x, &stiffness);
    }
    return finish(&of, "static mode", "d", stiffness);
}

PyObject *static_free(PyObject *args)
{
    call of = {.status = AOI_OK};
    size_t n = ANY_LENGTH, count = ANY_LENGTH;
    const double *rigid, *b;
    double *phi_st, mass = 0.0;
    TAKE(&of, args, MATRIX('d', rigid, count, n), ARRAY('d', b, n), ARRAY('D', phi_st, n));
    if (of.status == AOI_OK) {
        of.status = aoi_static_free(n, count, rigid, b, phi_st, &mass);
    }
    return finish(&of, "static mode", "d", mass);
}

PyObject *constraint_project(PyObject *args)
{
    call of = {.status = AOI_OK};
    size_t n = ANY_LENGTH;
    const double *b, *z;
    double *x;
    TAKE(&of, args, ARRAY('d', b, n), ARRAY('d', z, n), ARRAY('D', x, n));
    if (of.status == AOI_OK) {
        of.status = aoi_constraint_project(n, b, z, x);
    }
    return finish(&of, "constraint modes", "");
}

PyObject *constraint_reflector(PyObject *args)
{
    call of = {.status = AOI_OK};
    size_t n = ANY_LENGTH;
    const double *b;
    double *h;
    TAKE(&of, args, ARRAY('d', b, n), ARRAY('D', h, n));
    if (of.status == AOI_OK) {
        of.status = aoi_constraint_reflector(n, b, h);
    }
    return finish(&of, "constraint modes", "");
}

PyObject *constraint_congruence(PyObject *args)
{
    call of = {.status = AOI_OK};
    size_t n = ANY_LENGTH;
    const double *h;
    double *a, *work;
    TAKE(&of, args, ARRAY('d', h, n), MATRIX('D', a, n, n), ARRAY('D', work, n));
    if (of.status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        aoi_constraint_congruence(n, h, a, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&of, "constraint modes", "");
}

PyObject *star_from_constraint_modes(PyObject *args)
{
    call of = {.status = AOI_OK};
    size_t n = ANY_LENGTH, count = ANY_LENGTH;
    aoi_star star = {.n = 0};
    const double *phi_st, *m_phi_st, *phi, *m_phi, *omega2;
    double k0, *m, *k, *coefficient;
    int32_t *oscillator;
    TAKE(&of, args, ARRAY('d', phi_st, n), ARRAY('d', m_phi_st, n), VALUE('x', k0), MATRIX('d', phi, count, n),
         MATRIX('d', m_phi, count, n), ARRAY('d', omega2, count), ARRAY('D', m, count), ARRAY('D', k, count),
         ARRAY('D', coefficient, count), ARRAY('I', oscillator, count));
    if (of.status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        of.status = aoi_star_from_constraint_modes(n, count, phi_st, m_phi_st, k0, phi, m_phi, omega2, &star, m, k,
                                                   coefficient, oscillator);
        Py_END_ALLOW_THREADS
    }
    return finish(&of, "anti-oscillators", "nd", (Py_ssize_t)star.n, star.m0);
}
