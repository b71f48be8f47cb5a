/* Sums that are whole numbers come out exact, whatever the length and however it is unrolled. */
#include "check.h"
#include "linear/vector.h"

enum { LONGEST = 67 };

static void sums_of_whole_numbers_are_exact(void)
{
    double ones[LONGEST], rising[LONGEST];
    for (int i = 0; i < LONGEST; i++) {
        ones[i] = 1.0;
        rising[i] = i + 1.0;
    }
    for (size_t n = 0; n <= LONGEST; n++) {
        const double whole = (double)n;
        CHECK(aoi_vector_dot(n, ones, rising) == whole * (whole + 1.0) / 2.0, "1 + ... + %zu", n);
        CHECK(aoi_vector_dot(n, rising, rising) ==
                  whole * (whole + 1.0) * (2.0 * whole + 1.0) / 6.0,
              "sum of the first %zu squares", n);
    }
}

static void product_with_a_unit_vector_picks_one_entry(void)
{
    double x[LONGEST], unit[LONGEST] = {0.0};
    for (size_t i = 0; i < LONGEST; i++) {
        x[i] = sin((double)i) + 2.0;
    }
    for (size_t i = 0; i < LONGEST; i++) {
        unit[i] = 1.0;
        CHECK(aoi_vector_dot(LONGEST, unit, x) == x[i], "entry %zu", i);
        unit[i] = 0.0;
    }
}

static void adding_touches_the_first_n_only(void)
{
    for (size_t n = 0; n < LONGEST; n++) {
        double x[LONGEST], y[LONGEST];
        for (size_t i = 0; i < LONGEST; i++) {
            x[i] = (double)i;
            y[i] = 100.0;
        }
        aoi_vector_add(n, -0.5, x, y);
        int right = 1;
        for (size_t i = 0; i < LONGEST; i++) {
            right = right && y[i] == (i < n ? 100.0 - 0.5 * (double)i : 100.0);
        }
        CHECK(right, "y - x/2 of %zu entries", n);
    }
}

static void nothing_is_a_vector_too(void)
{
    CHECK(aoi_vector_dot(0, NULL, NULL) == 0.0, "the empty sum");
    aoi_vector_add(0, 1.0, NULL, NULL);
}

int main(void)
{
    sums_of_whole_numbers_are_exact();
    product_with_a_unit_vector_picks_one_entry();
    adding_touches_the_first_n_only();
    nothing_is_a_vector_too();
    return check_report();
}
