/* The adaptive run: closed forms, its own dense output, and steps of any stiffness. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 16, ROWS = 60000 };

typedef struct scene {
    double omega[MOST], weight[MOST], load[MOST], x[MOST], v[MOST];
    size_t order[MOST], n;
    aoi_relative relative;
    aoi_law law;
    aoi_adaptive run;
    double *track, *block;
    size_t rows;
} scene;

static aoi_law law_of(const char *name, double k, double n)
{
    const double parameter[] = {k, n};
    aoi_law law;
    CHECK(aoi_law_create(&law, name, strcmp(name, "power") == 0 ? 2 : 1, parameter) == AOI_OK, "law");
    return law;
}

static void run_scene(scene *s, aoi_law law, double rtol, double end)
{
    for (size_t j = 0; j < s->n; j++) {
        s->order[j] = j;
    }
    s->relative.n = s->relative.n_projectile = s->n;
    s->relative.omega = s->omega;
    s->relative.weight = s->weight;
    s->relative.load = s->load;
    s->law = law;
    s->track = malloc(ROWS * (AOI_TRACK_FIXED + 2 * s->n) * sizeof(double));
    s->block = malloc(AOI_TABLES * aoi_collocation_size(s->n) * sizeof(double));
    s->run = (aoi_adaptive){.relative = &s->relative, .law = &s->law, .rtol = rtol, .end = end};
    s->run.x = s->x;
    s->run.v = s->v;
    s->run.block = s->block;
    s->run.order = s->order;
    CHECK(aoi_adaptive_start(&s->run) == AOI_OK, "it starts");
    CHECK(aoi_adaptive_run(&s->run, ROWS, s->track, &s->rows) == AOI_OK, "it runs");
    CHECK(s->run.time == end, "to the end: %g of %g", s->run.time, end);
}

static void release(scene *s)
{
    free(s->track);
    free(s->block);
}

/* int_0^1 dx / sqrt(1 - x^(n+1)) by tanh-sinh quadrature. */
static double half_duration(double n)
{
    double sum = 0.0;
    for (int i = -400; i <= 400; i++) {
        const double t = 0.01 * i, s = 0.5 * PI * sinh(t);
        const double left = 1.0 / (1.0 + exp(2.0 * s)); /* 1 - x, without cancellation */
        const double weight = 0.01 * 0.5 * PI * cosh(t) * 0.5 / (cosh(s) * cosh(s));
        sum += weight / sqrt(-expm1((n + 1.0) * log1p(-left)));
    }
    return sum;
}

static void power_laws_on_a_wall(void)
{
    const double exponents[] = {1.0, 1.5, 2.0, 3.0};
    for (size_t e = 0; e < 4; e++) {
        for (int tolerance = 3; tolerance <= 11; tolerance += 2) {
            const double n = exponents[e], k = 1e7, mass = 0.4, velocity = 2.0;
            const double rtol = pow(10.0, -tolerance);
            const double deepest =
                pow((n + 1.0) * mass * velocity * velocity / (2.0 * k), 1.0 / (n + 1.0));
            const double duration = 2.0 * deepest / velocity * half_duration(n);
            scene s = {.n = 1};
            s.weight[0] = 1.0 / mass;
            s.v[0] = velocity;
            run_scene(&s, law_of("power", k, n), rtol, 2.0 * duration);
            CHECK(near(s.run.peak_force, k * pow(deepest, n), rtol), "n %g, rtol %g: peak", n, rtol);
            CHECK(near(s.run.impulse, 2.0 * mass * velocity, rtol), "n %g, rtol %g: impulse", n, rtol);
            CHECK(near(s.v[0], -velocity, rtol), "n %g, rtol %g: rebound %.12g", n, rtol, s.v[0]);
            double let_go = -1.0;
            for (size_t i = 0; i < s.rows; i++) {
                const double *row = s.track + i * (AOI_TRACK_FIXED + 2);
                let_go = row[AOI_TRACK_RELEASE] >= 0.0 ? row[AOI_TRACK_RELEASE] : let_go;
            }
            CHECK(near(let_go, duration, rtol), "n %g, rtol %g: duration %.12g", n, rtol, let_go);
            release(&s);
        }
    }
}

/* A mass on a spring on a linear law: in contact two oscillators, whose motion is a sum of sines. */
static void ringing_contact_follows_its_normal_modes(void)
{
    const double m0 = 0.01, m1 = 1.0, k1 = 1e6, k = 1e5, v = 1.0, reduced = m0 * m1 / (m0 + m1);
    scene s = {.n = 2};
    s.weight[0] = 1.0 / (m0 + m1);
    s.omega[1] = sqrt(k1 / reduced);
    s.weight[1] = 1.0 / m0 - 1.0 / (m0 + m1);
    s.v[0] = v;
    run_scene(&s, law_of("linear", k, 1.0), 1e-11, 5e-3);
    /* (k - w^2 m0) u0 + k1 (u0 - u1) = 0, -w^2 m1 u1 + k1 (u1 - u0) = 0 */
    const double a = m0 * m1, b = -(m1 * (k + k1) + m0 * k1), c = k * k1;
    const double root = sqrt(b * b - 4.0 * a * c);
    const double w2[2] = {2.0 * c / (-b + root), (-b + root) / (2.0 * a)};
    double sine[2], share[2];
    for (int i = 0; i < 2; i++) {
        const double other = k1 / (k1 - w2[i] * m1); /* u1 / u0 */
        const double mass = m0 + m1 * other * other;
        share[i] = v * (m0 + m1 * other) / mass / sqrt(w2[i]);
    }
    for (size_t i = 0; i < s.rows; i++) {
        const double *row = s.track + i * (AOI_TRACK_FIXED + 4);
        for (int p = 0; row[AOI_TRACK_CONTACT] == 1.0 && p < 3; p++) {
            const double t = row[AOI_TRACK_START] + 0.5 * p * row[AOI_TRACK_LENGTH];
            double slope;
            const double ours = aoi_legendre_evaluate(AOI_STAGES + 1, row + AOI_TRACK_INDENTATION,
                                                      0.5 * p, &slope);
            sine[0] = share[0] * sin(sqrt(w2[0]) * t);
            sine[1] = share[1] * sin(sqrt(w2[1]) * t);
            if (s.track && row[AOI_TRACK_RELEASE] < 0.0) {
                CHECK(fabs(ours - sine[0] - sine[1]) < 1e-11 * (share[0] + fabs(share[1])),
                      "t %g: indentation %.15g, not %.15g", t, ours, sine[0] + sine[1]);
            }
        }
    }
    release(&s);
}

/* Bounces under gravity, as high as at first: each keeps its energy to the tolerance. */
static void a_bouncing_ball_keeps_its_height(void)
{
    const double g = 9.81, v = 0.1, mass = 0.03;
    scene s = {.n = 1};
    s.weight[0] = 1.0 / mass;
    s.load[0] = g;
    s.v[0] = v;
    run_scene(&s, law_of("hertz", 1e9, 0.0), 1e-13, 4.0);
    size_t bounces = 0;
    for (size_t i = 0; i < s.rows; i++) {
        bounces += s.track[i * (AOI_TRACK_FIXED + 2) + AOI_TRACK_RELEASE] >= 0.0;
    }
    CHECK(bounces > 190, "it bounces: %zu times", bounces);
    for (size_t i = 0; i < s.rows; i++) {
        const double *row = s.track + i * (AOI_TRACK_FIXED + 2);
        const double energy = 0.5 * row[AOI_TRACK_FIXED + 1] * row[AOI_TRACK_FIXED + 1] -
                              g * row[AOI_TRACK_FIXED];
        if (row[AOI_TRACK_CONTACT] == 0.0) {
            CHECK(near(energy, 0.5 * v * v, 1e-13 * (double)bounces), "row %zu: energy off by %g", i,
                  energy / (0.5 * v * v) - 1.0);
        }
    }
    release(&s);
}

static void dense_output_meets_the_rows(void)
{
    scene s = {.n = 2};
    s.weight[0] = 10.0;
    s.weight[1] = 90.0;
    s.omega[1] = 1e5;
    s.v[0] = 1.0;
    run_scene(&s, law_of("hertz", 1e9, 0.0), 1e-9, 1e-3);
    const double centre[2] = {1.0, 0.0};
    const aoi_centres centres = {centre, {0.0, 0.0}};
    const size_t width = AOI_TRACK_FIXED + 4;
    for (size_t i = 0; i + 1 < s.rows; i++) {
        const double *row = s.track + i * width, *next = row + width;
        const double time = row[AOI_TRACK_START] + row[AOI_TRACK_LENGTH];
        double values[AOI_ROW_COUNT], work[4], *where[AOI_ROW_COUNT];
        for (size_t r = 0; r < AOI_ROW_COUNT; r++) {
            where[r] = values + r;
        }
        /* From the row before alone: its end is where the next one starts. */
        CHECK(aoi_track_sample(&s.relative, &s.law, &centres, 1, row, 1, &time, where, work) == AOI_OK,
              "sampled");
        const double place = next[AOI_TRACK_FIXED] + next[AOI_TRACK_FIXED + 1];
        const double speed = next[AOI_TRACK_FIXED + 2] + next[AOI_TRACK_FIXED + 3];
        CHECK(fabs(values[AOI_ROW_BODY] - place) < 1e-16, "row %zu: displacement", i);
        CHECK(fabs(values[AOI_ROW_BODY + 1] - speed) < 1e-12, "row %zu: velocity", i);
    }
    release(&s);
}

static void senseless_runs_are_refused(void)
{
    aoi_relative relative = {.n = 0};
    aoi_adaptive run = {.relative = &relative, .rtol = 1e-6, .end = 1.0};
    CHECK(aoi_adaptive_start(&run) == AOI_ERROR_ARGUMENT, "nothing that could move");
    relative.n = 1;
    run.rtol = 0.0;
    CHECK(aoi_adaptive_start(&run) == AOI_ERROR_ARGUMENT, "no tolerance");
    run.rtol = 1e-6;
    run.end = 0.0;
    CHECK(aoi_adaptive_start(&run) == AOI_ERROR_ARGUMENT, "no time");
}

int main(void)
{
    power_laws_on_a_wall();
    ringing_contact_follows_its_normal_modes();
    a_bouncing_ball_keeps_its_height();
    dense_output_meets_the_rows();
    senseless_runs_are_refused();
    return check_report();
}
