/* All that a test program needs: CHECK says what physics failed, check_report closes. */
#ifndef AOIMPACT_TEST_CHECK_H
#define AOIMPACT_TEST_CHECK_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>

#define PI 3.14159265358979323846
#define SMALLEST 4.9406564584124654e-324 /* above zero; C99 has no name for it */

enum { CHECK_MOST_SHOWN = 20 };

static int check_passed, check_failed;

#if defined(__GNUC__)
__attribute__((format(printf, 5, 6)))
#endif
static inline void
check_that(int holds, const char *file, int line, const char *condition, const char *what, ...)
{
    if (holds) {
        check_passed++;
        return;
    }
    if (++check_failed > CHECK_MOST_SHOWN) {
        return;
    }
    va_list arguments;
    va_start(arguments, what);
    printf("%s:%d: ", file, line);
    vprintf(what, arguments);
    printf(" [%s]\n", condition);
    va_end(arguments);
}

/* CHECK(condition, what it means in physics, printf arguments) */
#define CHECK(condition, ...)                                                                      \
    check_that((condition) != 0, __FILE__, __LINE__, #condition, __VA_ARGS__)

/* The closing line, and main's return value. */
static inline int check_report(void)
{
    printf("%d passed, %d failed\n", check_passed, check_failed);
    return check_failed != 0;
}

/* |a - b| <= tolerance |b|, false for NaN. */
static inline int near(double a, double b, double tolerance)
{
    return a == b || fabs(a - b) <= tolerance * fabs(b);
}

/* Repeatable uniform numbers in (0, 1): a 64-bit linear congruence, upper bits. */
static inline double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return ((double)(*state >> 11) + 0.5) / 9007199254740992.0;
}

/* 10^x with x uniform in (low, high). */
static inline double decades(uint64_t *state, double low, double high)
{
    return pow(10.0, low + (high - low) * uniform(state));
}

#endif
