/* Bytes of libFuzzer read as numbers, arrays and laws: what the harnesses share. Arrays are allocated to
 * their exact size, so that a read or write beside them is seen. */
#ifndef AOIMPACT_FUZZ_H
#define AOIMPACT_FUZZ_H

#include "aoimpact.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Ends the process with what does not hold. */
#define REQUIRE(condition)                                                                         \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, #condition);         \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

enum { MOST_ARRAYS = 512 };

/* What is left of the bytes (zeros follow), and all arrays of this input. */
typedef struct input {
    const uint8_t *at;
    size_t left;
    double decades; /* numbers lie within 10^(-+decades) */
    int spoiled;    /* but for one or the other */
    void *array[MOST_ARRAYS];
    size_t arrays;
} input;

static inline unsigned take_byte(input *in)
{
    if (in->left == 0) {
        return 0;
    }
    in->left--;
    return *in->at++;
}

static inline size_t take_below(input *in, size_t limit) { return limit ? take_byte(in) % limit : 0; }

static inline size_t take_between(input *in, size_t least, size_t most)
{
    return least + take_below(in, most - least + 1);
}

static inline double take_share(input *in)
{
    const unsigned high = take_byte(in);
    return (256.0 * high + take_byte(in)) / 65535.0;
}

/* Log-uniform within the decades of this input. */
static inline double take_positive(input *in)
{
    return pow(10.0, in->decades * (2.0 * take_share(in) - 1.0));
}

/* Often zero, of either sign. */
static inline double take_signed(input *in)
{
    const unsigned kind = take_byte(in) % 4;
    return kind == 0 ? 0.0 : kind == 1 ? -take_positive(in) : take_positive(in);
}

static inline double take_not_negative(input *in)
{
    return take_byte(in) % 4 == 0 ? 0.0 : take_positive(in);
}

static inline double take_exponent(input *in) { return 1.0 + 4.0 * take_share(in); }

/* Anything that a double can be. */
static inline double take_any(input *in)
{
    const double special[] = {0.0,     -0.0,     1.0,      -1.0,      DBL_MIN,       DBL_MAX,
                              -DBL_MAX, 5e-324,  -5e-324,  INFINITY,  -INFINITY,     NAN,
                              1e154,   1e-154,   0.5 * DBL_MAX, DBL_EPSILON};
    const unsigned kind = take_byte(in) % 32;
    if (kind < 16) {
        return special[kind];
    }
    if (kind < 24) {
        return take_signed(in);
    }
    uint64_t bits = 0;
    double value;
    for (int i = 0; i < 8; i++) {
        bits = bits << 8 | take_byte(in);
    }
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline input open_input(const uint8_t *data, size_t size)
{
    static const double widths[] = {1.0, 3.0, 6.0, 12.0, 30.0, 100.0};
    input in = {.at = data, .left = size};
    in.decades = widths[take_below(&in, sizeof widths / sizeof widths[0])];
    return in;
}

static inline void *take_bytes(input *in, size_t count, size_t size)
{
    void *array = calloc(count ? count : 1, size); /* UBSan: no NULL for the empty */
    if (!array || in->arrays == MOST_ARRAYS) {
        abort();
    }
    return in->array[in->arrays++] = array;
}

static inline double *take_room(input *in, size_t count) { return take_bytes(in, count, sizeof(double)); }

typedef double taker(input *in);

static inline double *take_array(input *in, size_t count, taker *one)
{
    double *array = take_room(in, count);
    for (size_t i = 0; i < count; i++) {
        array[i] = one(in);
    }
    return array;
}

static inline void close_input(input *in)
{
    while (in->arrays > 0) {
        free(in->array[--in->arrays]);
    }
}

/* Rarely, one number of an array is replaced by anything; says whether. */
static inline int spoil(input *in, double *array, size_t count)
{
    if (count == 0 || take_byte(in) < 250) {
        return 0;
    }
    array[take_below(in, count)] = take_any(in);
    in->spoiled = 1;
    return 1;
}

/* ------------------------------------------------------------------------------------------ laws */

/* A law of the caller's, as bad as such may be. */
typedef struct odd_law {
    unsigned kind;
    double a, b, place;
} odd_law;

static inline double odd_force(void *data, int which, double d, double rate)
{
    const odd_law *of = data;
    const double x = d / of->place;
    if (which == AOI_USER_POTENTIAL) {
        return 0.5 * of->a * d * d;
    }
    if (which != AOI_USER_FORCE) {
        return of->a;
    }
    switch (of->kind) {
    case 0:
        return of->a * d + of->b * rate;
    case 1:
        return x < 1.0 ? of->a * d : 2.0 * of->a * d; /* jumps up */
    case 2:
        return x < 1.0 ? of->a * d : 0.5 * of->a * d; /* jumps down */
    case 3:
        return x < 1.0 ? of->a * d : (double)NAN;
    case 4:
        return of->a * of->place * x * x / (1.0 + x * x); /* levels off */
    case 5:
        return -of->a * d;
    case 6:
        return of->a * d * (1.0 + 0.5 * sin(x));
    case 7:
        return of->a; /* at once */
    default:
        return of->a * d * fabs(rate);
    }
}

/* A law by name, of a table, or the caller's. status: of its making. */
static inline aoi_law take_law(input *in, int *status)
{
    static const struct {
        const char *name;
        size_t count;
        taker *second; /* the first is a stiffness, a third one an exponent or what the next says */
        taker *third;
    } kinds[] = {{"hertz", 1, NULL, NULL},
                 {"power", 2, take_exponent, NULL},
                 {"linear", 1, NULL, NULL},
                 {"hunt_crossley", 3, take_not_negative, NULL},
                 {"tsuji", 2, take_not_negative, NULL},
                 {"kuwabara_kono", 2, take_not_negative, NULL},
                 {"kelvin_voigt", 2, take_not_negative, NULL},
                 {"kelvin_voigt_pulling", 2, take_not_negative, NULL},
                 {"thornton", 2, take_positive, NULL},
                 {"elastic_plastic", 3, take_positive, take_positive},
                 {"yang_sun", 3, take_positive, take_share}};
    enum { NAMED = sizeof kinds / sizeof kinds[0] };
    aoi_law law;
    const size_t kind = take_below(in, NAMED + 2);
    if (kind == NAMED) {
        const size_t count = take_between(in, 2, 5);
        double *table = take_room(in, 4 * count);
        for (size_t i = 1; i < count; i++) {
            table[i] = table[i - 1] + take_positive(in);
            table[count + i] = table[count + i - 1] + take_not_negative(in);
        }
        for (size_t i = 1; i < count; i++) { /* slopes between which the cubics do not fall */
            const double length = table[i] - table[i - 1], *force = table + count, *slope = force + count;
            const double rise = (force[i] - force[i - 1]) / length;
            table[2 * count + i] = fmin(rise, i + 1 < count ? (force[i + 1] - force[i]) / (table[i + 1] - table[i])
                                                            : rise);
            table[3 * count + i] = table[3 * count + i - 1] +
                                   0.5 * length * ((force[i - 1] + force[i]) +
                                                   length * (slope[i - 1] - slope[i]) / 6.0);
        }
        (void)spoil(in, table, 4 * count);
        *status = aoi_law_create_table(&law, count, table);
    } else if (kind > NAMED) {
        odd_law *of = take_bytes(in, 1, sizeof *of);
        *of = (odd_law){take_below(in, 9), take_positive(in), take_not_negative(in), take_positive(in)};
        aoi_user_law user = {.call = odd_force, .data = of, .given = {1, 0, 0, 0}};
        user.given[AOI_USER_POTENTIAL] = take_byte(in) & 1;
        *status = aoi_law_create_user(&law, &user, of->kind == 0 || of->kind == 8, take_byte(in) % 4 == 0);
    } else {
        double parameter[3];
        parameter[0] = take_positive(in);
        parameter[1] = kinds[kind].second ? kinds[kind].second(in) : 0.0;
        parameter[2] = (kinds[kind].third ? kinds[kind].third : take_exponent)(in);
        (void)spoil(in, parameter, kinds[kind].count);
        *status = aoi_law_create(&law, kinds[kind].name, kinds[kind].count, parameter);
    }
    if (*status == AOI_OK && take_byte(in) % 4 == 0) { /* on a patch */
        law.compliance = take_byte(in) % 2 ? take_positive(in) : -take_positive(in);
        law.limit = fmin(law.limit, take_positive(in));
    }
    if (*status == AOI_OK) {
        *status = aoi_law_check(&law);
    }
    return law;
}

/* Friction of a law that can have it, for half of the contacts, and often what is taken out of it: a symmetric matrix,
 * but for spoiled ones. NULL: none. */
static inline const aoi_friction *take_friction(input *in, const aoi_law *law, const double **compliance)
{
    aoi_friction *of = take_bytes(in, 1, sizeof *of);
    if (take_byte(in) & 1 || aoi_friction_create(of, law, take_not_negative(in), take_positive(in),
                                                 pow(10.0, -1.0 - 3.0 * take_share(in))) != AOI_OK) {
        return NULL;
    }
    if (take_byte(in) & 1) {
        double *c = take_array(in, 9, take_signed);
        c[0] = law->compliance;
        c[3] = c[1];
        c[6] = c[2];
        c[7] = c[5];
        (void)spoil(in, c, 9);
        *compliance = c;
    }
    return of;
}

/* Whether it may give no number. */
static inline int may_fail(const aoi_law *law)
{
    return law->user.call != NULL || law->compliance != 0.0;
}

#endif
