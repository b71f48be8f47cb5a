/* Friction along the motion of a step: see sliding.h. */
#include "collocation/sliding.h"
#include "collocation/newton.h"
#include "motion/nodes.h"
#include "motion/polynomial.h"

#include <math.h>
#include <string.h>

/* SHORT_WAY: half the interval over which slipping springs are tested for sticking, as a share of a step.
 * CHANGE_WIDTH: tolerance of the position at which slip begins or ends, as a share of a step. */
static const double SHORT_WAY = 1e-5, CHANGE_WIDTH = 1e-9;

/* Stops: the positions in a step (0 to 1, ascending) between which a path is straight. at: number of the point at
 * a stop; below AOI_NODES if forces are found there, from AOI_NODES on if the force is compared with its
 * polynomial, NO_POINT if neither. */
enum { MOST_POINTS = AOI_NODES + AOI_EDGE_CHECKS, NO_POINT = MOST_POINTS, MOST_STOPS = MOST_POINTS + 4 };
typedef struct stops {
    size_t count, at[MOST_STOPS];
    double place[MOST_STOPS];
} stops;

/* Results at the stops, indexed by the number of the point at each. */
typedef struct finds {
    aoi_oblique_solution at[MOST_POINTS + 1];
    double stretched[MOST_POINTS + 1]; /* energy of the springs, J; set only on request        */
} finds;

/* Motion of the bodies in a step: the indentation and two slides since the touch, as Legendre series. */
typedef struct motion {
    double series[3][AOI_NODES + 1];
} motion;

static motion motion_of(const aoi_contact_step *entry)
{
    motion made;
    for (size_t i = 0; i < 3; i++) {
        aoi_legendre_fit(entry[i].start, entry[i].indentation, made.series[i]);
    }
    return made;
}

static void add_stop(stops *of, double place, size_t number)
{
    size_t i = of->count++;
    for (; i > 0 && of->place[i - 1] > place; i--) {
        of->place[i] = of->place[i - 1];
        of->at[i] = of->at[i - 1];
    }
    of->place[i] = place;
    of->at[i] = number;
}

/* Sets n to the direction of friction at the start of a step or, if there is no friction, of the slide. */
static void direction_of(const aoi_sliding *of, const motion *along, double n[2])
{
    const double *force = of->path[1].force;
    const int acts = force[1] != 0.0 || force[2] != 0.0;
    for (size_t i = 0; i < 2; i++) {
        n[i] = acts ? force[1 + i] : along->series[1 + i][1];
    }
    const double size = hypot(n[0], n[1]);
    n[0] /= size > 0.0 ? size : 1.0;
    n[1] /= size > 0.0 ? size : 1.0;
}

/* Returns the stops of a step: the nodes, or an edge's quadrature points, and the positions at which springs begin
 * or cease to slip. All springs begin or cease to slip at once where the slide in the direction of friction, plus
 * or minus mu/ratio times the indentation, has an extremum. */
static stops stops_of(const aoi_sliding *of, enum aoi_edge edge, const motion *along)
{
    stops made = {.count = 0};
    const double slope = of->rub.friction.mu / of->rub.friction.ratio;
    double n[2];
    direction_of(of, along, n);
    for (size_t k = 0; k < AOI_NODES; k++) {
        add_stop(&made, aoi_radau_edge_point[edge][k], k);
    }
    for (int i = 0; i < 4; i++) {
        const double bound = i % 2 ? slope : -slope, sign = i / 2 ? 1.0 : -1.0;
        double series[AOI_NODES + 1], place, value;
        for (size_t k = 0; k <= AOI_NODES; k++) {
            series[k] = sign * (n[0] * along->series[1][k] + n[1] * along->series[2][k] + bound * along->series[0][k]);
        }
        if (aoi_legendre_top(AOI_NODES + 1, series, &place, &value)) {
            add_stop(&made, place, NO_POINT);
        }
    }
    return made;
}

static void copy_path(const aoi_slide_path *from, aoi_slide_path *to)
{
    aoi_stretch *spring = to->springs.spring, *spare = to->springs.spare;
    memcpy(spring, from->springs.spring, from->springs.count * sizeof *spring);
    *to = *from;
    to->springs.spring = spring;
    to->springs.spare = spare;
}

/* Finds the forces after straight motion from a path's end to an indentation and slides of the bodies (place). The
 * path stays unchanged. */
static int look(const aoi_sliding *of, const double place[3], const aoi_slide_path *path, aoi_oblique_solution *found)
{
    aoi_oblique_equation equation = {.rate_free = 0.0}; /* the law is elastic */
    for (size_t i = 0; i < 3; i++) {
        equation.free[i] = place[i] - (i > 0 ? path->own[i - 1] : 0.0);
        equation.guess[i] = equation.free[i] + path->bent[i];
    }
    return aoi_rub_solve(&of->rub, &path->springs, &equation, found);
}

/* Moves a path straight to an indentation and slides of the bodies (place), and finds the forces there. */
static int go(const aoi_sliding *of, const double place[3], aoi_slide_path *path, aoi_oblique_solution *found)
{
    int status = look(of, place, path, found);
    if (status == AOI_OK) {
        status = aoi_friction_move(&of->exact, &path->springs, found->place[0], found->share, &found->place[1]);
    }
    if (status != AOI_OK) {
        return status;
    }
    for (size_t i = 0; i < 3; i++) {
        path->force[i] = found->force[i];
        path->bent[i] = found->place[i] - (place[i] - (i > 0 ? path->own[i - 1] : 0.0));
    }
    path->own[0] = place[1] + path->bent[1];
    path->own[1] = place[2] + path->bent[2];
    return AOI_OK;
}

/* Sets `place` to the indentation and slides of the bodies at a position of the step (at). */
static void bodies_at(const motion *along, double at, double place[3])
{
    for (size_t k = 0; k < 3; k++) {
        double slope;
        place[k] = aoi_legendre_evaluate(AOI_NODES + 1, along->series[k], at, &slope);
    }
}

/* Returns 1 if all springs slip at a position of the step (at) after a straight path from `from`, whose spare
 * springs are overwritten. slipped: 1 if all springs slip at `from`. Springs that stick begin to slip when their
 * stretch reaches its bound. Springs that slip all stick at once if the slide does not keep up with the bound,
 * which is tested over a short interval about the position. */
static int slips_at(const aoi_sliding *of, const motion *along, const aoi_slide_path *from, double at, int slipped)
{
    aoi_slide_path path = *from;
    aoi_oblique_solution found = {.stuck = 0.0};
    double place[3];
    int status = AOI_OK;
    if (slipped) {
        bodies_at(along, at - SHORT_WAY, place);
        status = go(of, place, &path, &found);
    }
    bodies_at(along, slipped ? at + SHORT_WAY : at, place);
    status = status == AOI_OK ? look(of, place, &path, &found) : status;
    return status == AOI_OK ? !(found.stuck > 0.0) : slipped;
}

/* Returns the position between `low` and `high` at which all springs begin or cease to slip, within `width`. from:
 * the path at `low`. */
static double change_between(const aoi_sliding *of, const motion *along, const aoi_slide_path *from, double low,
                             double high, int slipped, double width)
{
    while (high - low > width) {
        const double middle = 0.5 * (low + high);
        if (slips_at(of, along, from, middle, slipped) == slipped) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return 0.5 * (low + high);
}

/* Moves a path straight to a position of the step (at), and records where all springs begin or cease to slip. */
static int go_on(aoi_sliding *of, const motion *along, double before, double at, const double place[3],
                 aoi_slide_path *path, aoi_oblique_solution *found)
{
    const aoi_slide_path from = *path;
    const int status = go(of, place, path, found), slips = status == AOI_OK && !(found->stuck > 0.0);
    if (status != AOI_OK || slips == of->slips) {
        return status;
    }
    copy_path(&from, &of->trial); /* copied, since its springs are in the spare array now */
    if (of->changes == AOI_SLIP_CHANGES) {
        return AOI_OK;
    }
    const double change = change_between(of, along, &of->trial, before, at, of->slips, CHANGE_WIDTH);
    aoi_oblique_solution there = *found;
    double bodies[3];
    bodies_at(along, change, bodies);
    (void)look(of, bodies, &of->trial, &there);
    for (size_t i = 0; i < 2; i++) {
        of->change_stretch[i][of->changes] =
            there.force[0] > 0.0 ? there.force[1 + i] / there.force[0] * fmax(bodies[0], 0.0) : 0.0;
    }
    of->change_at[of->changes++] = change;
    of->slips = slips;
    return AOI_OK;
}

/* Moves a path along the motion of a step, in `parts` straight parts from one stop to the next. energies = 1: also
 * finds the energies of the springs. noted: receives the changes of slip; or NULL. */
static int follow(const aoi_sliding *of, const motion *along, const stops *to, size_t parts, int energies,
                  aoi_sliding *noted, aoi_slide_path *path, finds *found)
{
    double before = 0.0;
    for (size_t i = 0; i < to->count; before = to->place[i++]) {
        aoi_oblique_solution *here = &found->at[to->at[i]];
        double last = before;
        for (size_t part = 1; part <= parts; part++) {
            const double share = (double)part / (double)parts;
            const double at = part < parts ? before + (to->place[i] - before) * share : to->place[i];
            double place[3];
            bodies_at(along, at, place);
            const int status = noted ? go_on(noted, along, last, at, place, path, here) : go(of, place, path, here);
            if (status != AOI_OK) {
                return status;
            }
            last = at;
        }
        if (energies) {
            found->stretched[to->at[i]] = aoi_friction_energy(&of->rub.friction, &path->springs);
        }
    }
    return AOI_OK;
}

/* Returns the force extrapolated to parts of zero length, from the forces of the first path (whole parts) and the
 * second (half parts), whose errors have the ratio 4 to 1. */
static double extrapolated(double whole, double half)
{
    return half + (half - whole) / 3.0;
}

double aoi_sliding_force(const aoi_sliding *of, size_t axis)
{
    return extrapolated(of->path[0].force[axis], of->path[1].force[axis]);
}

void aoi_sliding_touch(aoi_sliding *of)
{
    for (size_t p = 0; p < AOI_PATHS; p++) {
        aoi_slide_path *path = &of->path[p];
        *path = (aoi_slide_path){.springs = {AOI_TRIED_SPRINGS, 0, path->springs.spring, path->springs.spare, 0.0, 0.0, 0.0}};
    }
    of->slide[0] = of->slide[1] = 0.0;
    of->stuck = 0.0;
}

int aoi_sliding_begin(aoi_sliding *of, const double place[3])
{
    aoi_oblique_solution found;
    double bound = 0.0;
    aoi_sliding_touch(of);
    for (size_t p = 0; p < AOI_PATHS; p++) {
        const int status = go(of, place, &of->path[p], &found);
        if (status != AOI_OK) {
            return status;
        }
    }
    of->slide[0] = place[1];
    of->slide[1] = place[2];
    of->stuck = found.place[0] > 0.0 ? found.stuck / found.place[0] : 0.0;
    of->slips = !(found.stuck > 0.0);
    for (size_t i = 0; i < 4; i++) {
        bound += 0.5 * found.force[1 + i / 2] * of->rub.compliance[1 + i / 2][1 + i % 2] * found.force[1 + i % 2];
    }
    of->work = aoi_friction_energy(&of->rub.friction, &of->path[0].springs) - bound;
    return AOI_OK;
}

void aoi_sliding_prepare(aoi_sliding *of, const aoi_contact_step *entry)
{
    memset(of->apart, 0, sizeof of->apart);
    static const size_t ahead[] = {AOI_NODES / 2 - 1, AOI_NODES - 3, AOI_NODES - 1};
    for (size_t p = 0; p < AOI_PATHS; p++) {
        aoi_slide_path *path = &of->path[p];
        for (size_t i = 0; i < sizeof ahead / sizeof *ahead; i++) {
            const double depth = entry[0].indentation[ahead[i]] + path->bent[0];
            const double slide[2] = {entry[1].indentation[ahead[i]] + path->bent[1] - path->own[0],
                                     entry[2].indentation[ahead[i]] + path->bent[2] - path->own[1]};
            /* springs are added only while there is room */
            (void)aoi_friction_refine(&of->rub.friction, &path->springs, depth, 1.0, slide);
        }
    }
}

int aoi_sliding_evaluate(aoi_sliding *of, const aoi_contact_step *entry, int both)
{
    const motion along = motion_of(entry);
    const stops to = stops_of(of, entry->edge, &along);
    finds found[AOI_PATHS];
    for (size_t p = 0; p < (both ? AOI_PATHS : 1); p++) {
        copy_path(&of->path[p], &of->trial);
        const int status = follow(of, &along, &to, p + 1, 0, NULL, &of->trial, &found[p]);
        if (status != AOI_OK) {
            return status;
        }
    }
    for (size_t i = 0; i < 3; i++) {
        const double before = of->path[1].force[i] - of->path[0].force[i];
        of->drift[i] = both ? 0.0 : of->drift[i];
        for (size_t k = 0; k < AOI_NODES; k++) {
            if (both) {
                of->apart[i][k] = found[1].at[k].force[i] - found[0].at[k].force[i];
                of->drift[i] = fmax(of->drift[i], fabs(of->apart[i][k] - before) / 3.0);
            }
            of->force[i][k] = extrapolated(found[0].at[k].force[i], found[0].at[k].force[i] + of->apart[i][k]);
            for (size_t j = 0; j < 3; j++) {
                of->by[i][j][k] = found[0].at[k].by_free[i][j];
            }
        }
    }
    return AOI_OK;
}

int aoi_sliding_check(aoi_sliding *of, const aoi_contact_step *entry)
{
    const motion along = motion_of(entry);
    const enum aoi_edge edge = entry->edge;
    stops to = stops_of(of, edge, &along);
    finds found;
    const size_t checks = aoi_edge_checks(edge);
    copy_path(&of->path[1], &of->trial);
    for (size_t k = 0; k < checks; k++) {
        if (aoi_radau_check_point[edge][k] > 0.0) {
            add_stop(&to, aoi_radau_check_point[edge][k], AOI_NODES + k);
        }
    }
    /* The check point that mirrors the last node is the start, where the force is known. */
    memcpy(found.at[2 * AOI_NODES - 1].force, of->trial.force, sizeof of->trial.force);
    const int status = follow(of, &along, &to, 1, 0, NULL, &of->trial, &found);
    for (size_t i = 0; i < 3 && status == AOI_OK; i++) {
        double force[AOI_NODES], series[AOI_NODES], there[AOI_EDGE_CHECKS];
        for (size_t k = 0; k < AOI_NODES; k++) {
            force[k] = found.at[k].force[i];
        }
        if (edge != AOI_EDGE_NONE) {
            aoi_edge_project(edge, force, force);
        }
        aoi_nodes_to_legendre(force, series);
        aoi_legendre_at_points(AOI_NODES, series, checks, aoi_radau_check_point[edge], there);
        for (size_t k = 0; k < checks; k++) {
            of->beyond[i][k] = found.at[AOI_NODES + k].force[i] - there[k];
        }
    }
    return status;
}

/* Returns 1 if all springs slip at the start of a step or, if the step begins with a touch, a short time after it. */
static int slips_first(const aoi_sliding *of, const motion *along)
{
    return of->path[1].springs.count > 0 ? of->slips : slips_at(of, along, &of->path[1], SHORT_WAY, 0);
}

double aoi_sliding_corner(aoi_sliding *of, const aoi_contact_step *entry, double beyond)
{
    const motion along = motion_of(entry);
    const stops to = stops_of(of, entry->edge, &along);
    int slips = slips_first(of, &along);
    double before = 0.0;
    copy_path(&of->path[1], &of->trial);
    for (size_t i = 0; i < to.count; before = to.place[i++]) {
        const aoi_slide_path from = of->trial;
        aoi_oblique_solution found;
        double place[3];
        bodies_at(&along, to.place[i], place);
        if (go(of, place, &of->trial, &found) != AOI_OK) {
            break;
        }
        if ((found.stuck > 0.0) == slips) { /* slip has begun or ended */
            const double change = change_between(of, &along, &from, before, to.place[i], slips, beyond * beyond);
            if (change > beyond) {
                return change;
            }
            slips = !slips;
        }
    }
    return 2.0;
}

/* Finds the ratio of friction to the normal force at the nodes of a step with an edge. After the contact has
 * ended, the ratio at a node is that at the node before, since all springs slip when the indentation falls to
 * zero. */
static void find_shares(aoi_sliding *of, const finds *found)
{
    for (size_t i = 0; i < 2; i++) {
        for (size_t k = 0; k < AOI_NODES; k++) {
            const double *whole = found[0].at[AOI_NODES + k].force, *half = found[1].at[AOI_NODES + k].force;
            const double normal = extrapolated(whole[0], half[0]), along = extrapolated(whole[1 + i], half[1 + i]);
            of->share[i][k] = normal > 0.0 ? along / normal : k > 0 ? of->share[i][k - 1] : 0.0;
        }
    }
}

/* Removes springs of a path at the end of a step that the precision does not require. If the history has so many
 * turns that more than AOI_KEPT_SPRINGS are left, a coarser precision removes further springs, which changes the
 * force of the path. */
static int thin_out(const aoi_sliding *of, const motion *along, aoi_slide_path *path)
{
    const double stays[2] = {0.0, 0.0}, indentation = path->springs.indentation;
    aoi_friction kept = of->rub.friction;
    aoi_oblique_solution found;
    double end[3];
    int status = aoi_friction_move(&kept, &path->springs, indentation, 1.0, stays);
    bodies_at(along, 1.0, end);
    while (status == AOI_OK && path->springs.count > AOI_KEPT_SPRINGS) {
        kept.precision *= 4.0; /* halves the number of springs of a smooth curve */
        status = aoi_friction_move(&kept, &path->springs, indentation, 1.0, stays);
        status = status == AOI_OK ? go(of, end, path, &found) : status;
    }
    path->springs.room = AOI_TRIED_SPRINGS;
    return status;
}

int aoi_sliding_advance(aoi_sliding *of, const aoi_contact_step *entry)
{
    const motion along = motion_of(entry);
    const int edge = entry->edge != AOI_EDGE_NONE;
    stops to = stops_of(of, entry->edge, &along);
    finds found[AOI_PATHS];
    for (size_t k = 0; k < AOI_NODES && edge; k++) {
        add_stop(&to, aoi_radau_node[k], AOI_NODES + k);
    }
    of->slipped = of->slips = slips_first(of, &along);
    of->changes = 0;
    for (size_t p = 0; p < AOI_PATHS; p++) {
        of->path[p].springs.room = AOI_SPRINGS;
        const int status = follow(of, &along, &to, p + 1, 1, p == 1 ? of : NULL, &of->path[p], &found[p]);
        if (status != AOI_OK) {
            return status;
        }
    }
    for (size_t k = 0; k <= AOI_NODES; k++) {
        if (k < AOI_NODES) {
            of->largest = fmax(of->largest, hypot(entry[1].force[k], entry[2].force[k]));
        }
        const size_t at = k < AOI_NODES ? k : edge ? 2 * AOI_NODES - 1 : AOI_NODES - 1;
        const aoi_oblique_solution *last = &found[1].at[at];
        of->stretched_at[k] = extrapolated(found[0].stretched[at], found[1].stretched[at]);
        of->stuck_at[k] = last->place[0] > 0.0 ? last->stuck / last->place[0] : 0.0;
    }
    of->slips = !(of->stuck_at[AOI_NODES] > 0.0);
    if (edge) {
        find_shares(of, found);
    }
    for (size_t p = 0; p < AOI_PATHS; p++) {
        const int status = thin_out(of, &along, &of->path[p]);
        if (status != AOI_OK) {
            return status;
        }
    }
    for (size_t i = 0; i < 2; i++) {
        of->slide[i] = entry[1 + i].indentation[AOI_NODES - 1];
        memcpy(of->last[i], along.series[1 + i], sizeof of->last[i]);
    }
    return AOI_OK;
}
