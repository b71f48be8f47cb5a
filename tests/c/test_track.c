/* Dense output: what a track says at any time between its rows, and that its ledger of energies closes. */
#include "plant.h"
#include "motion/modes.h"
#include "collocation/collocation.h"
#include "adaptive/row.h"

enum { MOST_ROWS = 128 };

/* All energies, losses less works of a record: constant. */
static double ledger(const plant *p, const double *record)
{
    double sum = 0.0;
    for (size_t c = 0; c < p->contacts; c++, record += AOI_CONTACT_ROWS) {
        sum += record[2] + record[3];
    }
    for (size_t b = 0; b < p->bodies; b++) {
        sum += record[AOI_BODY_KINETIC] + record[AOI_BODY_ELASTIC] + record[AOI_BODY_DISSIPATED] -
               record[AOI_BODY_WORK];
        record += AOI_BODY_ROWS + AOI_PORT_ROWS * p->part[b].ports;
    }
    return sum;
}

/* What a scene of two ringing bodies and a contact is made of. */
enum { GRAVITY = 1, STEADY = 2, RISING = 4, DAMPED = 8, MASSLESS = 16, VISCOUS = 32, PRESSED = 64,
       PULLING = 128 };

static void furnish(plant *p, int with, const aoi_law *law)
{
    uint64_t seed = 41;
    for (size_t b = 0; b < 2; b++) {
        part *of = add_ringing(p, 5, 2, 1.0 + (double)b, 4e3, b == 0 ? 1.0 : -0.5, &seed);
        const double rise = with & RISING ? 40.0 : 0.0;
        of->pulled = (with & GRAVITY) != 0;
        of->gravity[0] = b == 0 ? 9.81 : -4.0;
        of->damped = (with & DAMPED) != 0;
        of->massless = (with & MASSLESS) != 0;
        of->residual[0] = of->residual[3] = 3e-7;
        of->residual[1] = of->residual[2] = 1e-7;
        of->load_count = with & (STEADY | RISING) ? 3 : 0;
        for (size_t i = 0; i < 3; i++) {
            of->load_time[i] = 4e-3 * (double)i;
            of->load_force[2 * i] = 20.0 + rise * (double)(i % 2);
            of->load_force[2 * i + 1] = -10.0 + rise * (double)(i * i);
        }
        for (size_t j = 0; j < of->n; j++) {
            of->decay[j] = 20.0 * (double)(j * j);
        }
    }
    join(p, 0, 0, 1, 1, with & PRESSED ? -1e-4 : 1e-4, law);
}

static void the_ledger_closes(int with, const char *what)
{
    const double end = 0.012, rtol = 1e-10;
    const aoi_law law = with & VISCOUS   ? law_named("hunt_crossley", 3, 1e7, 0.2, 1.5)
                        : with & PULLING ? law_named("kelvin_voigt_pulling", 2, 1e5, 50.0, 0.0)
                                         : hertz(1e7);
    double record[MOST_ROWS], first = 0.0, scale = 1.0;
    plant p = {.bodies = 0};
    furnish(&p, with, &law);
    must_go(&p, rtol, end);
    CHECK(aoi_adaptive_peak(p.run, 0).impulse > 0.5, "%s: they meet", what);
    CHECK(open_sampler(&p) == AOI_OK && aoi_record_rows(&p.system) <= MOST_ROWS, "%s: sampled", what);
    for (int i = 0; i <= 400; i++) {
        const double t = end * i / 400.0;
        aoi_sampler_column(p.sampler, t, 1, record, 1);
        first = i == 0 ? ledger(&p, record) : first;
        CHECK(i > 0 || (fabs(record[4 + AOI_BODY_WORK]) < 1e-12 && fabs(record[14 + AOI_BODY_WORK]) < 1e-12),
              "%s: no work at the start", what);
        CHECK(fabs(ledger(&p, record) - first) < 30.0 * rtol * scale, "%s: at %g the ledger is off by %g J", what,
              t, ledger(&p, record) - first);
    }
    release(&p);
}

/* A ball on a spring without mass falls on a wall again and again, which each time pulls until it lets go:
 * what the spring holds then is lost. */
static void pulls_that_end_are_booked(void)
{
    const double compliance = 1e-3, rtol = 1e-9;
    const aoi_law law = law_named("kelvin_voigt_pulling", 2, 1e4, 10.0, 0.0);
    double record[MOST_ROWS], lost = 0.0;
    plant p = ball_on_wall(1.0, 1.0, &law);
    part *ball = &p.part[0];
    ball->pulled = ball->massless = 1;
    ball->gravity[0] = 9.81;
    ball->residual[0] = compliance;
    must_go(&p, rtol, 1.0);
    for (size_t r = 0; r < p.track.rows; r++) {
        const double *row = p.track.values + p.track.row[r];
        const double *of = row + (size_t)row[AOI_TRACK_SIZE] - AOI_TRACK_CONTACT_SIZE;
        if (row[AOI_TRACK_CONTACTS] > 0.0 && of[AOI_TRACK_ENDS] > 0.0) {
            const double pull = of[AOI_TRACK_FORCE + AOI_NODES - 1];
            lost += 0.5 * compliance * pull * pull;
        }
    }
    CHECK(aoi_adaptive_peak(p.run, 0).impulse > 5.0 && lost > 1e-3, "it bounces, and loses %g J so", lost);
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (int i = 0; i <= 100; i++) {
        aoi_sampler_column(p.sampler, 0.01 * i, 1, record, 1);
        CHECK(fabs(ledger(&p, record) - 0.5) < 1e2 * rtol, "at %g s the ledger is at %.12g J", 0.01 * i,
              ledger(&p, record));
    }
    release(&p);
}

/* A place is pressed on a wall by o. A body that leaves pulls it away, and lets go: it springs back, to where a spring of
 * its compliance and the wall's are pressed by o. */
static void a_place_that_springs_back_is_booked(void)
{
    const double soft = 1e-5, k = 1e6, o = 1e-4, rtol = 1e-9, end = 5e-3;
    const aoi_law wall = linear(k), pulling = law_named("kelvin_voigt_pulling", 2, 1e4, 1e2, 0.0);
    double record[MOST_ROWS], first = 0.0;
    plant p = {.bodies = 0};
    part *place = add_rigid(&p, 1e12, 0.0);
    place->massless = 1;
    place->residual[0] = soft;
    add_wall(&p);
    add_rigid(&p, 1.0, -1.0);
    join_rigid(&p, 0, 1, -o, &wall);
    join_rigid(&p, 2, 0, -2.0 * o, &pulling);
    must_go(&p, rtol, end);
    CHECK(aoi_adaptive_peak(p.run, 0).impulse > 0.0 && !p.run->contact[1].is_closed, "the pull is over");
    CHECK(near(p.run->contact[0].closed.force, o / (soft + 1.0 / k), rtol), "back on the wall with %g N", p.run->contact[0].closed.force);
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (int i = 0; i <= 100; i++) {
        const double t = 0.01 * end * i;
        aoi_sampler_column(p.sampler, t, 1, record, 1);
        first = i == 0 ? ledger(&p, record) : first;
        CHECK(fabs(ledger(&p, record) - first) < 1e2 * rtol, "at %g s the ledger is off by %g J", t,
              ledger(&p, record) - first);
    }
    release(&p);
}

static void ledgers_close(void)
{
    the_ledger_closes(0, "alone");
    the_ledger_closes(GRAVITY, "gravity");
    the_ledger_closes(STEADY, "steady loads");
    the_ledger_closes(RISING, "rising loads");
    the_ledger_closes(MASSLESS, "massless contacts");
    the_ledger_closes(DAMPED, "damping");
    the_ledger_closes(VISCOUS, "viscous contact");
    the_ledger_closes(STEADY | MASSLESS, "steady loads on massless contacts");
    the_ledger_closes(RISING | MASSLESS, "rising loads on massless contacts");
    the_ledger_closes(RISING | DAMPED, "rising loads, damping");
    the_ledger_closes(RISING | PRESSED | MASSLESS, "pressed together from the start");
    the_ledger_closes(MASSLESS | PULLING, "a pull that ends at once");
    the_ledger_closes(STEADY | MASSLESS | PULLING, "loads and pulls");
    the_ledger_closes(RISING | GRAVITY | DAMPED | MASSLESS | VISCOUS, "everything");
}

/* No force acts on a mass but a load that rises: v = f' t^2 / 2m, and its work is its kinetic energy; a
 * damped mass loses what is missing. */
static void work_and_losses_are_those_of_the_motion(void)
{
    for (int damped = 0; damped < 2; damped++) {
        plant p = {.bodies = 0};
        part *ball = add_rigid(&p, 2.0, 0.0);
        ball->damped = damped;
        ball->decay[0] = 3.0;
        ball->load_count = 2;
        ball->load_time[1] = 1.0;
        ball->load_force[1] = 12.0;
        must_go(&p, 1e-9, 1.0);
        double record[AOI_BODY_ROWS + AOI_PORT_ROWS];
        CHECK(open_sampler(&p) == AOI_OK, "sampled");
        aoi_sampler_column(p.sampler, 0.5, 1, record, 1);
        /* v' + 2 s v = 6 t: v = (6 t - v_lag)/(2 s), v_lag = 6 (1 - e^(-2 s t))/(2 s). */
        const double q = 6.0, t = 0.5, e = exp(-q * t);
        const double v = damped ? 6.0 * (t / q - (1.0 - e) / (q * q)) : 3.0 * t * t;
        CHECK(near(record[AOI_BODY_CENTRE_VELOCITY], v, 1e-13), "velocity %.15g, not %.15g",
              record[AOI_BODY_CENTRE_VELOCITY], v);
        CHECK(near(record[AOI_BODY_KINETIC], v * v, 1e-13), "m v^2 / 2");
        /* int f v dt, f = 12 t */
        const double moment = (1.0 - e * (1.0 + q * t)) / (q * q); /* of e^(-q t) */
        const double work = damped ? 72.0 * (t * t * t / (3.0 * q) - (t * t / 2.0 - moment) / (q * q)) : v * v;
        CHECK(near(record[AOI_BODY_WORK], work, 1e-12), "work %.15g, not %.15g", record[AOI_BODY_WORK], work);
        CHECK(fabs(record[AOI_BODY_DISSIPATED] - (work - v * v)) < 1e-13, "the rest is lost");
        release(&p);
    }
}

/* From the row before alone, its end is where the next one starts. */
static void dense_output_meets_the_rows(void)
{
    uint64_t seed = 12;
    const aoi_law law = hertz(1e9);
    plant p = {.bodies = 0};
    add_ringing(&p, 2, 1, 0.1, 1e5, 1.0, &seed);
    add_wall(&p);
    join_rigid(&p, 0, 1, 0.0, &law);
    must_go(&p, 1e-9, 1e-3);
    const size_t rows = p.track.rows, *index = p.track.row;
    for (size_t r = 0; r + 1 < rows; r++) {
        const double *row = p.track.values + index[r], *next = p.track.values + index[r + 1];
        const double time = row[AOI_TRACK_START] + row[AOI_TRACK_LENGTH];
        double state[4];
        p.track.rows = r + 1;
        p.track.used = index[r + 1];
        CHECK(open_sampler(&p) == AOI_OK, "sampled");
        aoi_sampler_state(p.sampler, time, 0, state);
        CHECK(row[AOI_TRACK_LENGTH] == 0.0 || near(next[AOI_TRACK_START], time, 1e-15), "no hole");
        if (row[AOI_TRACK_LENGTH] > 0.0) {
            const double *of = next + AOI_TRACK_FIXED + AOI_TRACK_STATE;
            CHECK(next[AOI_TRACK_FIXED] == 0.0, "the moved body is in the next row");
            for (size_t j = 0; j < 4; j++) {
                CHECK(fabs(state[j] - of[j]) < (j < 2 ? 1e-16 : 1e-12), "row %zu: %zu", r, j);
            }
            aoi_modes_advance(p.body, time, time + 1e-5, state, state + 2);
            double later[4];
            aoi_sampler_state(p.sampler, time + 1e-5, 0, later);
            for (size_t j = 0; j < 4; j++) {
                CHECK(fabs(state[j] - later[j]) < (j < 2 ? 1e-16 : 1e-12), "row %zu: %zu flies on", r, j);
            }
        }
    }
    p.track.rows = 0;
    CHECK(open_sampler(&p) == AOI_ERROR_ARGUMENT, "a track without rows has no states");
    release(&p);
}

/* The forces alone are those of the record, to the last bit where the times do not lie evenly (test_even.c). */
static double uneven(size_t i) { return 0.012 * pow((double)i / 49.0, 1.5); }

static void forces_alone_are_those_of_the_record(void)
{
    const aoi_law law = hertz(1e7);
    plant p = {.bodies = 0};
    furnish(&p, GRAVITY, &law);
    must_go(&p, 1e-8, 0.012);
    static double all[MOST_ROWS * 50];
    const size_t rows = aoi_record_rows(&p.system);
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (size_t i = 0; i < 50; i++) {
        aoi_sampler_column(p.sampler, uneven(i), 1, all + i, 50);
    }
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (size_t i = 0; i < 50; i++) {
        double force[MOST_CONTACTS];
        aoi_sampler_forces(p.sampler, uneven(i), force, 1);
        for (size_t c = 0; c < p.system.contact_count; c++) {
            CHECK(force[c] == all[AOI_CONTACT_ROWS * c * 50 + i], "force %zu, column %zu", c, i);
        }
    }
    double record[MOST_ROWS];
    for (size_t k = 0; k < rows; k++) {
        record[k] = -77.0;
    }
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    aoi_sampler_column(p.sampler, 0.006, 0, record, 1);
    CHECK(record[2] == -77.0 && record[3] == -77.0 && record[4 + AOI_BODY_KINETIC] == -77.0 &&
              record[4 + AOI_BODY_WORK] == -77.0 && record[4] != -77.0,
          "energies that nobody wants are left alone");
    release(&p);
}

static int is_refused(plant *p) { return open_sampler(p) == AOI_ERROR_ARGUMENT; }

/* Tracks that are not whole, or not of this system, are refused before anything is read. */
static void what_is_no_track_is_refused(void)
{
    const aoi_law law = hertz(1e7);
    plant p = {.bodies = 0};
    furnish(&p, 0, &law);
    must_go(&p, 1e-6, 2e-3);
    const size_t used = p.track.used, rows = p.track.rows, last = p.track.row[rows - 1];
    size_t contact_row = 0;
    while (p.track.values[p.track.row[contact_row] + AOI_TRACK_CONTACTS] == 0.0) {
        contact_row++;
    }
    const size_t row = p.track.row[contact_row];
    const size_t contact = row + (size_t)p.track.values[row + AOI_TRACK_SIZE] - AOI_TRACK_CONTACT_SIZE;
    const struct {
        size_t at;
        double value;
    } wrong[] = {{AOI_TRACK_BODIES, 3.0},      {AOI_TRACK_BODIES, -1.0}, {AOI_TRACK_BODIES, NAN},
                 {AOI_TRACK_BODIES, 1.0},      {AOI_TRACK_CONTACTS, 2.0}, {AOI_TRACK_CONTACTS, 0.5},
                 {AOI_TRACK_FIXED, 2.0},       {AOI_TRACK_FIXED, 1e300},  {contact, 1.0},
                 {contact + AOI_TRACK_PIECE, NAN}, {contact + AOI_TRACK_PIECE, -2.0},
                 {row + AOI_TRACK_LENGTH, 0.0}, {row + AOI_TRACK_LENGTH, NAN},
                 {AOI_TRACK_START, NAN},       {AOI_TRACK_START, 1.0},
                 {last + AOI_TRACK_START, 0.0}, {last + AOI_TRACK_START, HUGE_VAL}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const double kept = p.track.values[wrong[i].at];
        p.track.values[wrong[i].at] = wrong[i].value;
        CHECK(is_refused(&p), "case %zu", i);
        p.track.values[wrong[i].at] = kept;
    }
    p.track.values[contact + AOI_TRACK_PIECE] = AOI_SLACK;
    p.track.values[contact + AOI_TRACK_EDGE] = AOI_EDGE_START;
    CHECK(is_refused(&p), "the edge of a force that is none");
    p.track.values[contact + AOI_TRACK_EDGE] = AOI_EDGE_NONE;
    CHECK(open_sampler(&p) == AOI_OK, "no force");
    p.track.used = used - 1;
    CHECK(is_refused(&p), "cut off");
    p.track.used = used + 1;
    CHECK(is_refused(&p), "more than its rows");
    p.track.used = used;
    p.track.row[rows - 1] = SIZE_MAX;
    CHECK(is_refused(&p), "pointing far away");
    p.track.row[rows - 1] = used;
    CHECK(is_refused(&p), "pointing past the end");
    p.track.row[rows - 1] = last;
    CHECK(open_sampler(&p) == AOI_OK, "the track itself is sound");
    release(&p);
}

/* A damped mass under a load with bends, looked at in any order: its energies add up, and it is where it flies from
 * the start in one go. */
static void samples_may_be_taken_in_any_order(void)
{
    const double time[] = {0.1, 0.35, 0.6, 0.8}, force[] = {0.0, 3.0, -4.0, 1.0};
    const double look[] = {0.0, 0.5, 1.0, 0.3, 0.9, 0.7};
    plant p = {.bodies = 0};
    part *bob = add_rigid(&p, 0.5, 0.3);
    bob->omega[0] = 40.0;
    bob->damped = 1;
    bob->decay[0] = 0.8;
    bob->load_count = 4;
    memcpy(bob->load_time, time, sizeof time);
    memcpy(bob->load_force, force, sizeof force);
    must_go(&p, 1e-9, 1.0);
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (size_t i = 0; i < sizeof look / sizeof *look; i++) {
        double of[MOST_ROWS], x = 0.0, v = 0.3;
        aoi_modes_advance(p.body, 0.0, look[i], &x, &v);
        aoi_sampler_column(p.sampler, look[i], 1, of, 1);
        const double sum = of[AOI_BODY_KINETIC] + of[AOI_BODY_ELASTIC] + of[AOI_BODY_DISSIPATED] - of[AOI_BODY_WORK];
        CHECK(near(sum, 0.5 * 0.5 * 0.3 * 0.3, 1e-12), "at %g s: %g J", look[i], sum);
        CHECK(near(of[AOI_BODY_CENTRE], x, 1e-11), "at %g s: %.15g m, not %.15g", look[i], of[AOI_BODY_CENTRE], x);
    }
    release(&p);
}

int main(void)
{
    what_is_no_track_is_refused();
    ledgers_close();
    pulls_that_end_are_booked();
    a_place_that_springs_back_is_booked();
    work_and_losses_are_those_of_the_motion();
    dense_output_meets_the_rows();
    forces_alone_are_those_of_the_record();
    samples_may_be_taken_in_any_order();
    return check_report();
}
