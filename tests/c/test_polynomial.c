/* Polynomials over a step: their values, fits, falls and tops; and that the nodes are Radau's. */
#include "numeric.h"
#include "law/law.h"
#include "motion/polynomial.h"
#include "motion/radau.h"

enum { COUNT = AOI_NODES + 1 };

static void random_coefficients(uint64_t *seed, double *coefficient)
{
    for (int k = 0; k < COUNT; k++) {
        coefficient[k] = (2.0 * uniform(seed) - 1.0) / (1.0 + k);
    }
}

static void nodes_are_those_of_radau(void)
{
    for (size_t i = 0; i < AOI_NODES; i++) {
        const double x = aoi_radau_node[i];
        CHECK(fabs(legendre(AOI_NODES, x) - legendre(AOI_NODES - 1, x)) < 1e-14, "node %zu is a zero of P_8 - P_7", i);
        CHECK(i == 0 || x > aoi_radau_node[i - 1], "they ascend");
    }
    CHECK(aoi_radau_node[AOI_NODES - 1] == 1.0, "the last is the end");
    /* Their quadrature is exact to degree 14. */
    for (int power = 0; power <= 14; power++) {
        double sum = 0.0;
        for (size_t i = 0; i < AOI_NODES; i++) {
            sum += aoi_radau_to_legendre[0][i] * pow(aoi_radau_node[i], power);
        }
        CHECK(near(sum, 1.0 / (power + 1.0), 1e-14), "the integral of x^%d", power);
    }
}

static void values_and_slopes_are_sums_of_legendre_polynomials(void)
{
    uint64_t seed = 1;
    for (int run = 0; run < 50; run++) {
        double c[COUNT], slope, unused;
        random_coefficients(&seed, c);
        for (size_t count = 1; count <= COUNT; count++) {
            const double at = -0.2 + 1.4 * uniform(&seed), h = 1e-5;
            double sum = 0.0;
            for (size_t k = 0; k < count; k++) {
                sum += c[k] * legendre(k, at);
            }
            const double size = pow(3.0, (double)count);
            CHECK(fabs(aoi_legendre_evaluate(count, c, at, &slope) - sum) < 1e-15 * size, "%zu terms", count);
            const double rise = aoi_legendre_evaluate(count, c, at + h, &unused) -
                                aoi_legendre_evaluate(count, c, at - h, &unused);
            CHECK(fabs(slope - rise / (2.0 * h)) < 1e-6 * size, "%zu terms: slope", count);
        }
    }
}

static void a_fit_gives_its_polynomial_back(void)
{
    uint64_t seed = 2;
    for (int run = 0; run < 50; run++) {
        double c[COUNT], values[COUNT], fitted[COUNT], slope;
        random_coefficients(&seed, c);
        values[0] = aoi_legendre_evaluate(COUNT, c, 0.0, &slope);
        for (size_t i = 0; i < AOI_NODES; i++) {
            values[i + 1] = aoi_legendre_evaluate(COUNT, c, aoi_radau_node[i], &slope);
        }
        aoi_legendre_fit(values[0], values + 1, fitted);
        for (int k = 0; k < COUNT; k++) {
            CHECK(fabs(fitted[k] - c[k]) < 2e-14, "coefficient %d: %g, not %g", k, fitted[k], c[k]);
        }
    }
}

/* From the values of a function. */
static void fit(double (*f)(double), double *values, double *coefficient)
{
    values[0] = f(0.0);
    for (size_t i = 0; i < AOI_NODES; i++) {
        values[i + 1] = f(aoi_radau_node[i]);
    }
    aoi_legendre_fit(values[0], values + 1, coefficient);
}

static double parabola(double x) { return (x + 0.1) * (0.7 - x); } /* top at 0.3, zero at 0.7 */
static double rising(double x) { return 1.0 + x * x * x; }
static double waves(double x) { return x * (x - 0.3) * (x - 0.5) * (x - 0.9); }
static double two_tops(double x) { return 0.01 * x - (x - 0.2) * (x - 0.2) * (x - 0.8) * (x - 0.8); }
static double starting_at_zero(double x) { return x * (0.6 - x); }

static void falls_and_tops_of_a_parabola(void)
{
    double values[COUNT], c[COUNT], place = -1.0, value = -1.0;
    fit(parabola, values, c);
    CHECK(aoi_legendre_falls(values, c, 0.0, &place) == 1 && near(place, 0.7, 1e-14), "zero at %.17g", place);
    CHECK(aoi_legendre_falls(values, c, 0.04, &place) == 1 && near(parabola(place), 0.04, 1e-13) && place > 0.3,
          "a level that is passed");
    CHECK(aoi_legendre_falls(values, c, -0.5, &place) == 0, "a level that is not reached");
    CHECK(aoi_legendre_top(COUNT, c, &place, &value) == 1 && near(place, 0.3, 1e-12) && near(value, 0.16, 1e-14),
          "top at %.17g: %.17g", place, value);
    CHECK(aoi_legendre_top(3, c, &place, &value) == 1 && near(place, 0.3, 1e-12), "three terms are all");
}

static double dip(double x) { return (x - 0.4) * (x - 0.45); } /* between two nodes, -1/1600 deep */

static void a_dip_between_nodes_is_seen(void)
{
    double values[COUNT], c[COUNT], place = -1.0;
    fit(dip, values, c);
    CHECK(aoi_legendre_dips(c, -6e-4, 0.0, &place) == 1 && near(place, 0.4, 1e-12), "at %.17g", place);
    CHECK(aoi_legendre_dips(c, -7e-4, 0.0, &place) == 0, "not so deep");
}

static void what_rises_has_neither(void)
{
    double values[COUNT], c[COUNT], place, value;
    fit(rising, values, c);
    CHECK(aoi_legendre_falls(values, c, 0.9, &place) == 0, "it never falls");
    CHECK(aoi_legendre_top(COUNT, c, &place, &value) == 0, "nor has it a top inside");
}

static void the_first_fall_and_the_highest_top_count(void)
{
    double values[COUNT], c[COUNT], place, value;
    fit(waves, values, c);
    CHECK(aoi_legendre_falls(values, c, -1e-3, &place) == 1 && place < 0.3 + 1e-9,
          "the first of two falls: %.17g", place);
    CHECK(near(waves(place), -1e-3, 1e-12), "to that level");
    CHECK(aoi_legendre_top(COUNT, c, &place, &value) == 1 && place > 0.3 && place < 0.5,
          "one top, between the zeros: %.17g", place);
    const double h = 1e-4;
    CHECK(value >= waves(place - h) && value >= waves(place + h), "no neighbour is higher");
    fit(two_tops, values, c);
    CHECK(aoi_legendre_top(COUNT, c, &place, &value) == 1 && fabs(place - 0.8) < 0.02, "the higher top: %g", place);
    fit(starting_at_zero, values, c);
    c[0] -= 1e-15; /* to rounding, that is */
    CHECK(aoi_legendre_falls(values, c, 0.0, &place) == 1 && near(place, 0.6, 1e-13),
          "zero at the start is no fall: %.17g", place);
}

/* A slope that oscillates, by up to half a period from node to node: its tops may have a bottom right beside them. */
static void no_top_lies_hidden_between_nodes(void)
{
    uint64_t seed = 5;
    int hidden = 0;
    for (int i = 0; i < 20000; i++) {
        const double turns = 2.0 + 7.0 * uniform(&seed), phase = 2.0 * PI * uniform(&seed);
        const double rise = (2.0 * uniform(&seed) - 1.0) * turns;
        double values[COUNT] = {cos(phase)}, c[COUNT], place, value = -HUGE_VAL, most = -HUGE_VAL;
        for (size_t k = 0; k < AOI_NODES; k++) {
            values[k + 1] = cos(turns * aoi_radau_node[k] + phase) + rise * aoi_radau_node[k];
        }
        aoi_legendre_fit(values[0], values + 1, c);
        for (int at = 1; at < 1000; at++) {
            double before, here;
            (void)aoi_legendre_evaluate(COUNT, c, 1e-3 * (at - 1), &before);
            const double there = aoi_legendre_evaluate(COUNT, c, 1e-3 * at, &here);
            most = before > 0.0 && here <= 0.0 && there > most ? there : most;
        }
        const int found = aoi_legendre_top(COUNT, c, &place, &value);
        CHECK(most == -HUGE_VAL || (found && value >= most - 1e-12), "%.9g rad: a top of %.12g, found %.12g", turns,
              most, value);
        for (size_t k = 1; found && k < AOI_NODES; k++) { /* the slope rises at the nodes on both sides, or falls */
            double left, right;
            (void)aoi_legendre_evaluate(COUNT, c, aoi_radau_node[k - 1], &left);
            (void)aoi_legendre_evaluate(COUNT, c, aoi_radau_node[k], &right);
            hidden += place > aoi_radau_node[k - 1] && place < aoi_radau_node[k] && left * right > 0.0;
        }
    }
    CHECK(hidden > 10, "%d tops were hidden", hidden);
}

int main(void)
{
    nodes_are_those_of_radau();
    values_and_slopes_are_sums_of_legendre_polynomials();
    a_fit_gives_its_polynomial_back();
    falls_and_tops_of_a_parabola();
    a_dip_between_nodes_is_seen();
    what_rises_has_neither();
    the_first_fall_and_the_highest_top_count();
    no_top_lies_hidden_between_nodes();
    return check_report();
}
