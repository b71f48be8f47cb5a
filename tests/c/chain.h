/* A chain of n unit masses on unit springs, struck at its last mass: free, or held at its first by
 * one more spring. Its star and its modes in closed form (sums of sines), whatever n. */
#ifndef AOIMPACT_TEST_CHAIN_H
#define AOIMPACT_TEST_CHAIN_H

#include "check.h"
#include "aoimpact.h"

enum { CHAIN_MOST = 400 };

typedef struct chain {
    int n, held;
    double m[CHAIN_MOST], k[CHAIN_MOST];           /* of the n-1 anti-oscillators, by frequency */
    double omega2[CHAIN_MOST], weight[CHAIN_MOST]; /* of the n modes: r^2                      */
    aoi_star star;
} chain;

static inline double square(double x) { return x * x; }

static inline double chain_antiresonance_angle(int n, int held, int j)
{
    return held ? j * PI / n : (2 * j - 1) * PI / (2 * n - 1);
}

static inline void chain_make(chain *c, int n, int held)
{
    c->n = n;
    c->held = held;
    for (int j = 1; j < n; j++) {
        const double half = 0.5 * chain_antiresonance_angle(n, held, j);
        const double norm = held ? 2.0 * n : 2.0 * n - 1.0;
        c->m[j - 1] = 1.0 / (square(tan(half)) * norm);
        c->k[j - 1] = 4.0 * square(cos(half)) / norm;
    }
    for (int j = 0; j < n; j++) {
        const double half = held ? (2 * j + 1) * PI / (2.0 * (2 * n + 1)) : j * PI / (2.0 * n);
        c->omega2[j] = 4.0 * square(sin(half));
        c->weight[j] = held ? 4.0 * square(cos(half)) / (2 * n + 1)
                            : (j == 0 ? 1.0 : 2.0 * square(cos(half))) / n;
    }
    c->star = (aoi_star){(size_t)(n - 1), 1.0, held ? 1.0 / n : 0.0, c->m, c->k};
}

/* Receptance at the last mass, built up spring by spring. */
static inline double chain_receptance(int n, int held, double omega)
{
    const double x = omega * omega;
    double stiffness = held ? 1.0 - x : -x;
    for (int i = 1; i < n; i++) {
        stiffness = stiffness / (1.0 + stiffness) - x;
    }
    return 1.0 / stiffness;
}

#endif
