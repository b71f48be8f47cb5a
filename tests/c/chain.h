/* A chain of n unit masses on unit springs, struck at its last mass: free, or constrained at its first by
 * one more spring. Its star and its modes in closed form (sums of sines), whatever n. */
#ifndef AOIMPACT_TEST_CHAIN_H
#define AOIMPACT_TEST_CHAIN_H

#include "check.h"
#include "aoimpact.h"

enum { CHAIN_MOST = 400 };

typedef struct chain {
    int n, constrained;
    double m[CHAIN_MOST], k[CHAIN_MOST];           /* of the n-1 anti-oscillators, by frequency */
    double omega2[CHAIN_MOST], weight[CHAIN_MOST]; /* of the n modes: r^2                      */
    aoi_star star;
} chain;

static inline double square(double x) { return x * x; }

static inline double chain_antiresonance_angle(int n, int constrained, int j)
{
    return constrained ? j * PI / n : (2 * j - 1) * PI / (2 * n - 1);
}

static inline void chain_make(chain *c, int n, int constrained)
{
    c->n = n;
    c->constrained = constrained;
    for (int j = 1; j < n; j++) {
        const double half = 0.5 * chain_antiresonance_angle(n, constrained, j);
        const double norm = constrained ? 2.0 * n : 2.0 * n - 1.0;
        c->m[j - 1] = 1.0 / (square(tan(half)) * norm);
        c->k[j - 1] = 4.0 * square(cos(half)) / norm;
    }
    for (int j = 0; j < n; j++) {
        const double half = constrained ? (2 * j + 1) * PI / (2.0 * (2 * n + 1)) : j * PI / (2.0 * n);
        c->omega2[j] = 4.0 * square(sin(half));
        c->weight[j] = constrained ? 4.0 * square(cos(half)) / (2 * n + 1)
                            : (j == 0 ? 1.0 : 2.0 * square(cos(half))) / n;
    }
    c->star = (aoi_star){(size_t)(n - 1), 1.0, constrained ? 1.0 / n : 0.0, c->m, c->k};
}

/* Receptance at the last mass, built up spring by spring. */
static inline double chain_receptance(int n, int constrained, double omega)
{
    const double x = omega * omega;
    double stiffness = constrained ? 1.0 - x : -x;
    for (int i = 1; i < n; i++) {
        stiffness = stiffness / (1.0 + stiffness) - x;
    }
    return 1.0 / stiffness;
}

#endif
