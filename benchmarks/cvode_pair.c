/* Impact of two AO models (stars) under a power law by SUNDIALS CVODE, in plain C: analytic Jacobian;
 * touches, releases and peaks by root finding; absolute tolerances by the size of each unknown.
 *
 *   cc -O3 cvode_pair.c -lsundials_cvode -lsundials_nvecserial -lm
 *
 * benchmarks/adaptive.py builds and runs it. Standard input, numbers separated by white space:
 *   velocity gap duration, length (scale of displacements), k n of F = k d^n,
 *   then for the projectile and the target: count m0 k0, count times m k;
 *   then any number of runs: method (0 Adams, 1 BDF), iteration (0 fixed point, 1 Newton), rtol,
 *   repeats, limit [s].
 * Output, one line per run: "result", best time [s], peak force, duration of the first contact, velocity
 * of the projectile's centre of mass after the last contact, steps, right-hand sides; or "result
 * failed". */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

enum { MOST = 1024 };

typedef struct star {
    int n;
    double m0, k0, m[MOST], k[MOST];
} star;

typedef struct scene {
    double velocity, gap, duration, length, k, exponent;
    star body[2];
    int first[2], coordinates; /* contact's index in u of each body; size of u; y = (u, v) */
    double deadline;
} scene;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double indentation(const scene *s, const double *u)
{
    return u[s->first[0]] - u[s->first[1]] - s->gap;
}

static double law(const scene *s, double d, double *slope)
{
    *slope = 0.0;
    if (d <= 0.0) {
        return 0.0;
    }
    const double stiffness =
        s->k * (s->exponent == 1.5 ? sqrt(d) : pow(d, s->exponent - 1.0));
    *slope = s->exponent * stiffness;
    return stiffness * d;
}

static int slope(double t, N_Vector y_in, N_Vector rate_out, void *data)
{
    const scene *s = data;
    const double *u = NV_DATA_S(y_in), *v = u + s->coordinates;
    double *rate = NV_DATA_S(rate_out), *acceleration = rate + s->coordinates, stiffness;
    const double force = law(s, indentation(s, u), &stiffness);
    (void)t;
    memcpy(rate, v, (size_t)s->coordinates * sizeof *v);
    for (int b = 0; b < 2; b++) {
        const star *body = &s->body[b];
        const int c = s->first[b];
        double on_contact = (b == 0 ? -force : force) - body->k0 * u[c];
        for (int i = 0; i < body->n; i++) {
            const double pull = body->k[i] * (u[c + 1 + i] - u[c]);
            on_contact += pull;
            acceleration[c + 1 + i] = -pull / body->m[i];
        }
        acceleration[c] = isinf(body->m0) ? 0.0 : on_contact / body->m0;
    }
    return 0;
}

static int jacobian(double t, N_Vector y_in, N_Vector rate, SUNMatrix J, void *data, N_Vector a,
                    N_Vector b_in, N_Vector c_in)
{
    const scene *s = data;
    const int n = s->coordinates;
    double stiffness;
    (void)t, (void)rate, (void)a, (void)b_in, (void)c_in;
    (void)law(s, indentation(s, NV_DATA_S(y_in)), &stiffness);
    SUNMatZero(J);
    for (int i = 0; i < n; i++) {
        SM_ELEMENT_D(J, i, n + i) = 1.0;
    }
    for (int b = 0; b < 2; b++) {
        const star *body = &s->body[b];
        const int c = s->first[b], other = s->first[1 - b];
        double sum = body->k0 + stiffness;
        if (isinf(body->m0)) {
            continue;
        }
        for (int i = 0; i < body->n; i++) {
            sum += body->k[i];
            SM_ELEMENT_D(J, n + c, c + 1 + i) = body->k[i] / body->m0;
            SM_ELEMENT_D(J, n + c + 1 + i, c) = body->k[i] / body->m[i];
            SM_ELEMENT_D(J, n + c + 1 + i, c + 1 + i) = -body->k[i] / body->m[i];
        }
        SM_ELEMENT_D(J, n + c, c) = -sum / body->m0;
        SM_ELEMENT_D(J, n + c, other) = stiffness / body->m0;
    }
    return 0;
}

static int roots(double t, N_Vector y, double *g, void *data)
{
    const scene *s = data;
    const double *u = NV_DATA_S(y), *v = u + s->coordinates;
    (void)t;
    g[0] = indentation(s, u);
    g[1] = v[s->first[0]] - v[s->first[1]];
    return 0;
}

static double centre_velocity(const scene *s, const double *y)
{
    const star *body = &s->body[0];
    const double *v = y + s->coordinates + s->first[0];
    double momentum = body->m0 * v[0], mass = body->m0;
    for (int i = 0; i < body->n; i++) {
        momentum += body->m[i] * v[i + 1];
        mass += body->m[i];
    }
    return momentum / mass;
}

typedef struct found {
    double peak, begin, first, rebound;
    long steps, evaluations;
} found;

/* Integrates from root to root; collects the peak force, contact times and rebound velocity. */
static int walk(const scene *s, void *cvode, N_Vector y, found *out)
{
    double t = 0.0, stiffness;
    int touching = s->gap == 0.0;
    *out = (found){0.0, 0.0, -1.0, centre_velocity(s, NV_DATA_S(y)), 0, 0};
    while (t < s->duration) {
        const int status = CVode(cvode, s->duration, y, &t, CV_NORMAL);
        if (status < 0 || now() > s->deadline) {
            return -1;
        }
        const double *u = NV_DATA_S(y);
        const double force = law(s, indentation(s, u), &stiffness);
        out->peak = force > out->peak ? force : out->peak;
        int which[2] = {0, 0};
        if (status == CV_ROOT_RETURN) {
            CVodeGetRootInfo(cvode, which);
        }
        if (which[0] > 0) {
            touching = 1;
            out->begin = t;
        } else if (which[0] < 0 && touching) {
            touching = 0;
            out->first = out->first < 0.0 ? t - out->begin : out->first;
            out->rebound = centre_velocity(s, u);
        }
        if (status == CV_TSTOP_RETURN) {
            break;
        }
    }
    CVodeGetNumSteps(cvode, &out->steps);
    CVodeGetNumRhsEvals(cvode, &out->evaluations);
    return 0;
}

static int run(scene *s, SUNContext context, int method, int newton, double rtol, found *out)
{
    const int n = s->coordinates;
    N_Vector y = N_VNew_Serial(2 * n, context), atol = N_VNew_Serial(2 * n, context);
    for (int i = 0; i < n; i++) {
        const int ours = i < s->first[1];
        NV_Ith_S(y, i) = 0.0;
        NV_Ith_S(y, n + i) = ours ? s->velocity : 0.0;
        NV_Ith_S(atol, i) = rtol * s->length;
        NV_Ith_S(atol, n + i) = rtol * fabs(s->velocity);
    }
    void *cvode = CVodeCreate(method == 0 ? CV_ADAMS : CV_BDF, context);
    SUNMatrix J = NULL;
    SUNLinearSolver linear = NULL;
    SUNNonlinearSolver fixed_point = NULL;
    CVodeInit(cvode, slope, 0.0, y);
    CVodeSVtolerances(cvode, rtol, atol);
    CVodeSetUserData(cvode, s);
    CVodeSetMaxNumSteps(cvode, 100000000);
    CVodeSetStopTime(cvode, s->duration);
    CVodeRootInit(cvode, 2, roots);
    CVodeSetNoInactiveRootWarn(cvode);
    if (newton) {
        J = SUNDenseMatrix(2 * n, 2 * n, context);
        linear = SUNLinSol_Dense(y, J, context);
        CVodeSetLinearSolver(cvode, linear, J);
        CVodeSetJacFn(cvode, jacobian);
    } else {
        fixed_point = SUNNonlinSol_FixedPoint(y, 0, context);
        CVodeSetNonlinearSolver(cvode, fixed_point);
    }
    const int status = walk(s, cvode, y, out);
    CVodeFree(&cvode);
    if (newton) {
        SUNLinSolFree(linear);
        SUNMatDestroy(J);
    } else {
        SUNNonlinSolFree(fixed_point);
    }
    N_VDestroy(y);
    N_VDestroy(atol);
    return status;
}

static int read_scene(scene *s)
{
    int good = scanf("%lf %lf %lf %lf %lf %lf", &s->velocity, &s->gap, &s->duration, &s->length,
                     &s->k, &s->exponent) == 6;
    s->coordinates = 0;
    for (int b = 0; b < 2 && good; b++) {
        star *body = &s->body[b];
        good = scanf("%d %lf %lf", &body->n, &body->m0, &body->k0) == 3 && body->n <= MOST;
        for (int i = 0; i < body->n && good; i++) {
            good = scanf("%lf %lf", &body->m[i], &body->k[i]) == 2;
        }
        s->first[b] = s->coordinates;
        s->coordinates += body->n + 1;
    }
    return good;
}

int main(void)
{
    static scene s;
    SUNContext context;
    int method, newton, repeats;
    double rtol, limit;
    if (!read_scene(&s) || SUNContext_Create(NULL, &context) != 0) {
        fprintf(stderr, "no scene on standard input\n");
        return 1;
    }
    while (scanf("%d %d %lf %d %lf", &method, &newton, &rtol, &repeats, &limit) == 5) {
        double best = HUGE_VAL;
        found out;
        int status = 0;
        const double begin = now();
        s.deadline = begin + limit;
        for (int i = 0; i < repeats && status == 0 && (i == 0 || now() < begin + 1.0); i++) {
            const double start = now();
            status = run(&s, context, method, newton, rtol, &out);
            const double taken = now() - start;
            best = taken < best ? taken : best;
        }
        if (status != 0) {
            printf("result failed\n");
        } else {
            printf("result %.9g %.17g %.17g %.17g %ld %ld\n", best, out.peak, out.first, out.rebound,
                   out.steps, out.evaluations);
        }
        fflush(stdout);
    }
    SUNContext_Free(&context);
    return 0;
}
