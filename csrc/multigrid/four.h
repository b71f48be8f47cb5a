/* Operations on four floats or doubles at a time, by SSE2 instructions where available, otherwise one by one with
 * bit-identical results. gcc does not vectorise loops of four. */
#ifndef AOI_LINEAR_FOUR_H
#define AOI_LINEAR_FOUR_H

#include <stddef.h>

/* Returns the numbers per node in vectors that are read and written four numbers at a time: nodes with three
 * numbers get a fourth, unused one. */
static inline size_t aoi_four_width(size_t b) { return b == 3 ? 4 : b; }

#ifdef __SSE2__
#include <emmintrin.h>

typedef __m128 aoi_single_four;
static inline aoi_single_four aoi_single_load(const float *x) { return _mm_loadu_ps(x); }
static inline aoi_single_four aoi_single_fill(float x) { return _mm_set1_ps(x); }
static inline void aoi_single_store(aoi_single_four a, float *x) { _mm_storeu_ps(x, a); }
static inline aoi_single_four aoi_single_plus(aoi_single_four sum, aoi_single_four a, aoi_single_four b)
{
    return _mm_add_ps(sum, _mm_mul_ps(a, b));
}
static inline aoi_single_four aoi_single_minus(aoi_single_four sum, aoi_single_four a, aoi_single_four b)
{
    return _mm_sub_ps(sum, _mm_mul_ps(a, b));
}

typedef struct aoi_exact_four {
    __m128d low, high;
} aoi_exact_four;
static inline aoi_exact_four aoi_exact_load(const double *x)
{
    return (aoi_exact_four){_mm_loadu_pd(x), _mm_loadu_pd(x + 2)};
}
static inline aoi_exact_four aoi_exact_fill(double x)
{
    return (aoi_exact_four){_mm_set1_pd(x), _mm_set1_pd(x)};
}
static inline void aoi_exact_store(aoi_exact_four a, double *x)
{
    _mm_storeu_pd(x, a.low);
    _mm_storeu_pd(x + 2, a.high);
}
static inline aoi_exact_four aoi_exact_plus(aoi_exact_four sum, aoi_exact_four a, aoi_exact_four b)
{
    return (aoi_exact_four){_mm_add_pd(sum.low, _mm_mul_pd(a.low, b.low)),
                        _mm_add_pd(sum.high, _mm_mul_pd(a.high, b.high))};
}
static inline aoi_exact_four aoi_exact_minus(aoi_exact_four sum, aoi_exact_four a, aoi_exact_four b)
{
    return (aoi_exact_four){_mm_sub_pd(sum.low, _mm_mul_pd(a.low, b.low)),
                        _mm_sub_pd(sum.high, _mm_mul_pd(a.high, b.high))};
}

#else

#define AOI_FOUR(name, real)                                                                           \
    typedef struct name##_four {                                                                       \
        real of[4];                                                                                    \
    } name##_four;                                                                                     \
    static inline name##_four name##_load(const real *x)                                               \
    {                                                                                                  \
        return (name##_four){{x[0], x[1], x[2], x[3]}};                                                \
    }                                                                                                  \
    static inline name##_four name##_fill(real x) { return (name##_four){{x, x, x, x}}; }              \
    static inline void name##_store(name##_four a, real *x)                                            \
    {                                                                                                  \
        for (size_t k = 0; k < 4; k++) {                                                               \
            x[k] = a.of[k];                                                                            \
        }                                                                                              \
    }                                                                                                  \
    static inline name##_four name##_plus(name##_four sum, name##_four a, name##_four b)               \
    {                                                                                                  \
        for (size_t k = 0; k < 4; k++) {                                                               \
            sum.of[k] += a.of[k] * b.of[k];                                                            \
        }                                                                                              \
        return sum;                                                                                    \
    }                                                                                                  \
    static inline name##_four name##_minus(name##_four sum, name##_four a, name##_four b)              \
    {                                                                                                  \
        for (size_t k = 0; k < 4; k++) {                                                               \
            sum.of[k] -= a.of[k] * b.of[k];                                                            \
        }                                                                                              \
        return sum;                                                                                    \
    }

AOI_FOUR(aoi_single, float)
AOI_FOUR(aoi_exact, double)

#endif
#endif
