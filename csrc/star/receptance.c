/* The receptance of a body in modes. */
#include "star/receptance.h"

#include <math.h>

void aoi_modal_receptance(size_t n, const double *omega, const double *decay, const double *weight,
                          double residual, size_t count, const double *frequency, double *real,
                          double *imaginary)
{
    for (size_t i = 0; i < count; i++) {
        const double w = frequency[i];
        real[i] = residual;
        imaginary[i] = 0.0;
        for (size_t j = 0; j < n; j++) {
            /* Divided by the larger part, so that a resonance without damping is infinite, not NaN. */
            const double spring = (omega[j] - w) * (omega[j] + w), dashpot = 2.0 * decay[j] * w;
            if (dashpot == 0.0) {
                real[i] += weight[j] / spring;
                continue;
            }
            const double size = hypot(spring, dashpot);
            real[i] += weight[j] / size * (spring / size);
            imaginary[i] -= weight[j] / size * (dashpot / size);
        }
    }
}
