/* A ball strikes the middle of a simply supported beam, computed twice: to a tolerance, and in fixed steps by
 * Newmark's rule. First a ball against a rigid wall, where Hertz's contact is known in closed form. Last a ball against
 * the end of a rod, whose AO model is made from its constraint modes.
 *
 *     make -C csrc example          or by hand, from the repository:
 *     cc -Iinclude examples/impact.c build/core/libaoimpact.a -lm
 */
#include "aoimpact.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MODES = 20, ROWS = 4000, TIMES = 5, DOFS = 12 };

/* Mass and speed of the ball, kg, m/s; stiffness of Hertz's law, N/m^1.5. */
static const double MASS = 0.1, SPEED = 1.0, STIFFNESS = 1e10;

static void check(int status, const char *what)
{
    if (status != AOI_OK) {
        fprintf(stderr, "%s: %s\n", what, aoi_status_text(status));
        exit(1);
    }
}

static void agree(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "%s\n", what);
        exit(1);
    }
}

/* A beam of steel, 1 m x 50 mm x 20 mm, pinned at both ends, by its bending modes at midspan; every
 * second mode is zero there and left out. */
static void make_beam(double *omega, double *shape, double *centre, aoi_modes *beam)
{
    const double pi = acos(-1.0), length = 1.0, area = 0.05 * 0.02, inertia = 0.05 * 0.02 * 0.02 * 0.02 / 12.0;
    const double line_mass = 7850.0 * area, bending = 210e9 * inertia;
    for (int j = 0; j < MODES; j++) {
        const int half_waves = 2 * j + 1;
        const double wave_number = half_waves * pi / length, norm = sqrt(2.0 / (line_mass * length));
        omega[j] = wave_number * wave_number * sqrt(bending / line_mass);
        shape[j] = j % 2 ? -norm : norm;
        centre[j] = norm * 2.0 / (half_waves * pi); /* the mean of the mode's shape */
    }
    *beam = (aoi_modes){.n = MODES, .ports = 1, .omega = omega, .shape = shape, .push = shape, .centre = centre};
}

/* Runs to a tolerance, and prints the motion at some times. Sets the peak force, N, the duration of
 * the contact, s, and the rebound: ratio of the ball's velocity away from the body to SPEED. */
static void run_adaptive(const aoi_system *system, const aoi_start *start, double end, double *peak,
                         double *duration, double *rebound)
{
    const size_t room = aoi_adaptive_room(system), rows = aoi_record_rows(system);
    aoi_track track = {.capacity = ROWS * room, .row_capacity = ROWS};
    track.values = malloc(track.capacity * sizeof(double));
    track.row = malloc(ROWS * sizeof(size_t));
    aoi_adaptive *run = malloc(aoi_adaptive_size(system));
    aoi_sampler *sampler = malloc(aoi_sampler_size(system));
    aoi_interval work[1], contact[1];
    double *column = malloc(rows * sizeof(double));
    check(aoi_adaptive_start(run, system, start, 1e-8, end), "start");
    check(aoi_adaptive_finish(run, &track), "adaptive run");
    agree(aoi_track_intervals(system, &track, end, work, 1, contact) == 1, "they do not touch just once");
    check(aoi_sampler_start(sampler, system, &track), "dense output");
    printf("    t, us   force, N   ball, m/s\n");
    for (int i = 0; i < TIMES; i++) {
        const double time = contact->start + (contact->end - contact->start) * i / (TIMES - 1);
        aoi_sampler_column(sampler, time, 1, column, 1);
        *rebound = -column[aoi_record_body(system, 0) + AOI_BODY_CENTRE_VELOCITY] / SPEED;
        printf("%9.2f%11.2f%12.5f\n", 1e6 * time, column[AOI_CONTACT_FORCE], -*rebound * SPEED);
    }
    *peak = aoi_adaptive_peak(run, 0).force;
    *duration = contact->end - contact->start;
    free(run), free(sampler), free(track.values), free(track.row), free(column);
}

/* Runs in fixed steps, and returns the largest force of the record, N. */
static double run_newmark(const aoi_system *system, const aoi_start *start, double end, size_t steps)
{
    const aoi_rule rule = {end / (double)steps, 0.25, 0.5};
    aoi_newmark *run = malloc(aoi_newmark_size(system));
    double *record = malloc(aoi_record_rows(system) * (steps + 1) * sizeof(double)), peak = 0.0;
    size_t done;
    check(aoi_newmark_start(run, system, &rule, start, 1, record, steps + 1), "start");
    check(aoi_newmark_run(run, steps, &done), "Newmark's rule");
    for (size_t i = 0; i <= done; i++) {
        peak = fmax(peak, record[(aoi_record_contact(system, 0) + AOI_CONTACT_FORCE) * (steps + 1) + i]);
    }
    free(run), free(record);
    return peak;
}

/* Runs a ball against a body by both integrators; peak, duration and rebound as for
 * run_adaptive. */
static void strike(const char *what, const aoi_modes *ball, const aoi_modes *target, const aoi_law *law,
                   double *peak, double *duration, double *rebound)
{
    const aoi_modes bodies[] = {*ball, *target};
    const aoi_contact contact = {.body = {0, 1}, .law = law};
    aoi_system system = {.body_count = 2, .contact_count = 1, .body = bodies, .contact = &contact};
    void *links = malloc(aoi_system_size(&system));
    double v[1 + MODES] = {SPEED * MASS * ball->centre[0]}; /* modal velocity of the ball; the target is at rest */
    const aoi_start start = {.v = v};
    check(aoi_system_link(&system, links), "system");
    printf("A ball against %s\n", what);
    run_adaptive(&system, &start, 1e-3, peak, duration, rebound);
    const double newmark = run_newmark(&system, &start, 1e-3, 20000);
    printf("  peak %.3f N (Newmark %.3f N), duration %.3f us, restitution %.4f\n", *peak, newmark,
           1e6 * *duration, *rebound);
    agree(fabs(newmark / *peak - 1.0) < 1e-3, "the two integrators differ");
    free(links);
}

/* The AO model of the struck end of a steel rod, 0.2 m x 1 cm^2, held at the other end: DOFS
 * springs and lumped masses, of which the struck end is the last. Its constraint modes are closed
 * forms: the static mode is a straight line, and with the struck end held the other modes are
 * sines. m and k have room for DOFS; stiffness and mass are the struck end's entries of K and M. */
static void make_rod(aoi_star *star, double *m, double *k, double *stiffness, double *mass)
{
    enum { N = DOFS - 1 }; /* the struck end does not move in a constraint mode */
    const double pi = acos(-1.0), spring = 210e9 * 1e-4 * DOFS / 0.2, part = 7850.0 * 1e-4 * 0.2 / DOFS;
    double phi_st[DOFS], m_phi_st[DOFS], c[N], omega2[N], phi[N * DOFS], m_phi[N * DOFS];
    int32_t oscillator[N];
    *stiffness = spring;
    *mass = 0.5 * part;
    for (int i = 0; i < DOFS; i++) {
        phi_st[i] = (i + 1.0) / DOFS;
        m_phi_st[i] = (i < N ? part : *mass) * phi_st[i];
    }
    for (int j = 0; j < N; j++) {
        const double half = 0.5 * pi * (j + 1) / DOFS;
        omega2[j] = 4.0 * spring / part * sin(half) * sin(half);
        for (int i = 0; i < DOFS; i++) {
            phi[j * DOFS + i] = i < N ? sqrt(2.0 / (part * DOFS)) * sin(2.0 * half * (i + 1)) : 0.0;
            m_phi[j * DOFS + i] = part * phi[j * DOFS + i];
        }
    }
    check(aoi_star_from_constraint_modes(DOFS, N, phi_st, m_phi_st, spring / DOFS, phi, m_phi, omega2, star, m, k, c,
                                         oscillator),
          "AO model");
}

int main(void)
{
    const aoi_star rigid = {0, MASS, 0.0, NULL, NULL}, fixed = {0, HUGE_VAL, 0.0, NULL, NULL};
    double omega[MODES], shape[MODES], centre[MODES], peak, duration, rebound;
    void *ball_memory = malloc(aoi_star_modes_size(&rigid)), *wall_memory = malloc(aoi_star_modes_size(&fixed));
    aoi_modes ball, wall, beam;
    aoi_law hertz;
    check(aoi_law_create(&hertz, "hertz", 1, &STIFFNESS), "law");
    check(aoi_star_modes(&rigid, ball_memory, &ball), "ball");
    check(aoi_star_modes(&fixed, wall_memory, &wall), "wall");
    strike("a wall", &ball, &wall, &hertz, &peak, &duration, &rebound);
    const double depth = pow(1.25 * MASS * SPEED * SPEED / STIFFNESS, 0.4);
    const double force = STIFFNESS * pow(depth, 1.5), time = 2.943275 * depth / SPEED;
    printf("  Hertz: %.3f N, %.3f us, 1\n", force, 1e6 * time);
    agree(fabs(peak / force - 1.0) < 1e-6 && fabs(duration / time - 1.0) < 1e-6 && fabs(rebound - 1.0) < 1e-6,
          "not Hertz's contact");
    make_beam(omega, shape, centre, &beam);
    strike("a beam", &ball, &beam, &hertz, &peak, &duration, &rebound);
    double stiffness, mass, m[DOFS], k[DOFS];
    aoi_star end;
    aoi_modes rod;
    make_rod(&end, m, k, &stiffness, &mass);
    double sum = end.k0;
    for (size_t i = 0; i < end.n; i++) {
        sum += k[i];
    }
    agree(fabs(end.m0 / mass - 1.0) < 1e-9, "m0 is not the mass of the struck end");
    agree(fabs(sum / stiffness - 1.0) < 1e-9, "the springs at the struck end are not those of K");
    void *rod_memory = malloc(aoi_star_modes_size(&end));
    check(aoi_star_modes(&end, rod_memory, &rod), "rod");
    strike("the end of a rod", &ball, &rod, &hertz, &peak, &duration, &rebound);
    free(ball_memory), free(wall_memory), free(rod_memory);
    return 0;
}
