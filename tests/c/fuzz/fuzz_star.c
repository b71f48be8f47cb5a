/* Stars, their modes and back, and roots of the secular equation. */
#include "fuzz.h"
#include "star/secular.h"

enum { MOST = 8, FREQUENCIES = 3 };

/* Positive numbers, ascending; now and then two are equal. */
static double *take_ascending(input *in, size_t count, double least)
{
    double *of = take_room(in, count);
    for (size_t i = 0; i < count; i++) {
        least += take_byte(in) % 16 ? take_positive(in) : 0.0;
        of[i] = least;
    }
    return of;
}

static void and_back(input *in, size_t modes, const double *omega2, const double *participation)
{
    double *weight = take_room(in, modes), *m = take_room(in, modes - 1), *k = take_room(in, modes - 1);
    double m0, k0;
    for (size_t j = 0; j < modes; j++) {
        weight[j] = participation[j] * participation[j];
    }
    if (aoi_star_from_modal(modes, omega2, weight, &m0, &k0, m, k, NULL) != AOI_OK) {
        return;
    }
    REQUIRE(isfinite(m0) && isfinite(k0) && m0 > 0.0 && k0 >= 0.0);
    for (size_t i = 0; i + 1 < modes; i++) {
        REQUIRE(isfinite(m[i]) && isfinite(k[i]) && m[i] >= 0.0 && k[i] >= 0.0);
    }
}

static void of_star(input *in)
{
    const size_t n = take_below(in, MOST);
    double *k = take_room(in, n), *m = take_array(in, n, take_positive), *square = take_ascending(in, n, 0.0);
    for (size_t i = 0; i < n; i++) {
        k[i] = m[i] * square[i];
    }
    (void)spoil(in, k, n);
    (void)spoil(in, m, n);
    aoi_star star = {n, take_not_negative(in), take_not_negative(in), m, k};
    if (take_byte(in) > 250) {
        star.m0 = take_any(in);
    }
    if (aoi_star_check(&star) != AOI_OK) {
        return;
    }
    double kinetic, elastic, *omega = take_array(in, FREQUENCIES, take_any);
    double *receptance = take_room(in, FREQUENCIES), *u = take_array(in, n + 1, take_signed);
    REQUIRE(aoi_star_static_mass(&star) > 0.0);
    aoi_star_receptance(&star, FREQUENCIES, omega, receptance);
    aoi_star_energy(&star, u, u, &kinetic, &elastic);
    REQUIRE(kinetic >= 0.0 && elastic >= 0.0);
    double *omega2 = take_room(in, n + 1), *participation = take_room(in, n + 1), *work = take_room(in, n);
    size_t modes;
    if (aoi_star_to_modal(&star, omega2, participation, &modes, work, NULL) != AOI_OK) {
        return;
    }
    REQUIRE(modes == n + (star.m0 > 0.0));
    for (size_t j = 0; j < modes; j++) {
        REQUIRE(isfinite(omega2[j]) && omega2[j] >= (j > 0 ? omega2[j - 1] : 0.0));
        REQUIRE(isfinite(participation[j]) && participation[j] > 0.0);
    }
    if (modes > 0) {
        and_back(in, modes, omega2, participation);
    }
}

static void of_modes(input *in)
{
    const size_t count = take_between(in, 1, MOST);
    double *omega2 = take_ascending(in, count, take_not_negative(in));
    double *weight = take_array(in, count, take_positive);
    (void)spoil(in, omega2, count);
    (void)spoil(in, weight, count);
    double *participation = take_room(in, count);
    for (size_t j = 0; j < count; j++) {
        participation[j] = sqrt(weight[j]);
    }
    and_back(in, count, omega2, participation);
}

static void of_secular(input *in)
{
    const size_t n = take_between(in, 1, MOST);
    const aoi_secular s = {n, take_ascending(in, n, take_not_negative(in)),
                           take_array(in, n, take_positive), take_signed(in), take_not_negative(in),
                           take_byte(in) & 1};
    const ptrdiff_t gap = (ptrdiff_t)take_below(in, n + 1) - 1;
    const double ceiling = take_byte(in) % 4 ? take_positive(in) : take_any(in);
    size_t nearest;
    double offset;
    if (aoi_secular_root(&s, gap, ceiling, &nearest, &offset) == AOI_OK) {
        REQUIRE(nearest <= n && isfinite(offset));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    switch (take_below(&in, 3)) {
    case 0:
        of_modes(&in);
        break;
    case 1:
        of_secular(&in);
        break;
    default:
        of_star(&in);
    }
    close_input(&in);
    return 0;
}
