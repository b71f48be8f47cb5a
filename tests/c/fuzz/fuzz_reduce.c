/* From matrices to oscillators: dense vectors of any numbers. */
#include "fuzz.h"
#include "linear/vector.h"

enum { MOST = 6 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    const size_t n = take_between(&in, 1, MOST), count = take_below(&in, MOST);
    taker *some = take_byte(&in) % 4 ? take_signed : take_any;
    const double *b = take_array(&in, n, some), *z = take_array(&in, n, some);
    const double *many = take_array(&in, n * count, some);
    double *c = take_room(&in, count), *m = take_room(&in, count), *k = take_room(&in, count);
    const double *moved = take_array(&in, n * count, some), *omega2 = take_array(&in, count, take_any);
    int32_t of[MOST];
    aoi_star star;
    if (aoi_star_from_constraint_modes(n, count, b, z, 0.0, many, moved, omega2, &star, m, k, c, of) == AOI_OK) {
        REQUIRE(star.n <= count && isfinite(star.m0) && aoi_vector_is_finite(count, c));
        for (size_t j = 0; j < star.n; j++) {
            REQUIRE(m[j] >= 0.0 && k[j] >= 0.0);
        }
    }
    close_input(&in);
    return 0;
}
