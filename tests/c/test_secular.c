/* Roots of the secular equation where they are known, of chains of masses; and where they are not, that the function
 * vanishes there as well as its own terms' rounding lets it. */
#include "chain.h"
#include "star/secular.h"

#include <stdlib.h>

static void chain_interlaces(int n, int held)
{
    static chain c;
    chain_make(&c, n, held);
    const aoi_secular receptance = {(size_t)n, c.omega2, c.weight, 0.0, 0.0, 0};
    for (int j = 1; j < n; j++) {
        size_t nearest;
        double offset;
        const int status = aoi_secular_root(&receptance, j - 1, 0.0, &nearest, &offset);
        CHECK(status == AOI_OK, "antiresonance %d of %d", j, n);
        CHECK(nearest == (size_t)j || nearest == (size_t)(j - 1), "of its own gap");
        const double wanted = square(2.0 * sin(0.5 * chain_antiresonance_angle(n, held, j)));
        const double root = c.omega2[nearest] + offset;
        CHECK(fabs(root - wanted) < 4e-15 * n, "antiresonance %d of %d: %.17g, not %.17g", j, n, root, wanted);
    }
}

/* How well s vanishes: its value in long double over the sum of its terms' sizes. */
static double backward_error(const aoi_secular *s, size_t nearest, double offset)
{
    const long double origin = nearest < s->n ? (long double)s->pole[nearest] : 0.0L;
    long double sum = (long double)s->linear, size = fabsl((long double)s->linear);
    for (size_t j = 0; j < s->n; j++) {
        const long double term = (long double)s->weight[j] / (((long double)s->pole[j] - origin) - (long double)offset);
        sum += term;
        size += fabsl(term);
    }
    const long double x = s->power ? origin + (long double)offset : 1.0L;
    const long double value = (long double)s->constant + x * sum;
    return (double)(fabsl(value) / (fabsl((long double)s->constant) + fabsl(x) * size));
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Poles over nine decades or in tight clusters, weights from 1e-20 to 1, both kinds of function. */
static void extreme_spectra(void)
{
    enum { MOST = 200 };
    static double pole[MOST], weight[MOST];
    uint64_t seed = 1;
    double worst = 0.0;
    int roots = 0, failures = 0, outside = 0;
    for (int trial = 0; trial < 300; trial++) {
        const size_t n = 2 + (size_t)(uniform(&seed) * (trial % 10 ? 30 : MOST - 2));
        const int kind = trial % 3, power = trial / 3 % 2;
        for (size_t j = 0; j < n; j++) {
            pole[j] = kind == 0   ? decades(&seed, 0.0, 9.0)
                      : kind == 1 ? 1e6 * (1.0 + 1e-9 * uniform(&seed))
                                  : decades(&seed, -4.0, 5.0);
            weight[j] = decades(&seed, kind == 2 ? -2.0 : -20.0, 0.0);
        }
        qsort(pole, n, sizeof pole[0], ascending);
        for (size_t j = 1; j < n; j++) {
            if (pole[j] <= pole[j - 1]) {
                pole[j] = nextafter(pole[j - 1], 1e300);
            }
        }
        const double stiffness = power ? -decades(&seed, -10.0, 3.0) : 0.0;
        const double mass = power ? decades(&seed, -10.0, 0.0) : 0.0;
        const aoi_secular s = {n, pole, weight, stiffness, mass, power};
        for (ptrdiff_t gap = power ? -1 : 0; gap < (ptrdiff_t)n - (power ? 0 : 1); gap++) {
            size_t nearest = 0;
            double offset = 0.0, above = 2.0 * (pole[n - 1] - stiffness / mass);
            for (size_t j = 0; power && j < n; j++) {
                above += 2.0 * weight[j] / mass;
            }
            roots++;
            if (aoi_secular_root(&s, gap, above, &nearest, &offset) != AOI_OK) {
                failures++;
                continue;
            }
            /* On the right side of its pole, and not beyond the middle of the gap. */
            const int right_of_left = nearest == (gap < 0 ? n : (size_t)gap) && offset > 0.0;
            const int left_of_right = nearest == (size_t)(gap + 1) && offset < 0.0;
            outside += !(right_of_left || left_of_right);
            worst = fmax(worst, backward_error(&s, nearest, offset));
        }
    }
    CHECK(roots > 5000, "only %d roots tried", roots);
    CHECK(failures == 0, "%d of %d roots not found", failures, roots);
    CHECK(outside == 0, "%d of %d roots outside their gap", outside, roots);
    CHECK(worst < 64.0 * DBL_EPSILON, "s(x) is %g of its terms at a root", worst);
}

int main(void)
{
    for (int n = 2; n <= 300; n += n < 10 ? 1 : 29) {
        chain_interlaces(n, 0);
        chain_interlaces(n, 1);
    }
    extreme_spectra();
    return check_report();
}
