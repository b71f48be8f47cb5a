/* Python binding of AO models (stars) and their modes. */
#include "python/binding.h"

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

PyObject *star_to_modal(PyObject *args)
{
    call of = {.status = AOI_OK};
    signal_check signals;
    aoi_star star = {.n = ANY_LENGTH};
    size_t modes = 0;
    double *omega2, *participation, *work;
    TAKE(&of, args, VALUE('x', star.m0), VALUE('x', star.k0), ARRAY('d', star.m, star.n), ARRAY('d', star.k, star.n),
         LONGER('D', omega2, star.n, 1), LONGER('D', participation, star.n, 1), ARRAY('D', work, star.n));
    if (of.status == AOI_OK) {
        signal_check_release(&signals);
        of.status = aoi_star_to_modal(&star, omega2, participation, &modes, work, &signals.pause);
        signal_check_regain(&signals);
    }
    return finish(&of, "natural modes of a star", "n", (Py_ssize_t)modes);
}

PyObject *star_from_modal(PyObject *args)
{
    call of = {.status = AOI_OK};
    signal_check signals;
    size_t oscillators = ANY_LENGTH;
    const double *omega2, *weight;
    double m0 = 0.0, k0 = 0.0, *m, *k;
    TAKE(&of, args, LONGER('d', omega2, oscillators, 1), LONGER('d', weight, oscillators, 1),
         ARRAY('D', m, oscillators), ARRAY('D', k, oscillators));
    if (of.status == AOI_OK) {
        signal_check_release(&signals);
        of.status = aoi_star_from_modal(oscillators + 1, omega2, weight, &m0, &k0, m, k, &signals.pause);
        signal_check_regain(&signals);
    }
    return finish(&of, "star of a modal model", "dd", m0, k0);
}
