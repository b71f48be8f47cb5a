/* Friction of a contact: the stretches of springs that stick or slip, as a function of the depth at which each is
 * touched.
 *
 * The spring of depth x has the bound r = mu/ratio (d - x) on its stretch s, at the indentation d. On a straight
 * path the indentation and the slide change at constant rates, and so does r. A spring follows the slide while |s|
 * <= r. Once it slips, it slips up to the path's end, with s = r n. Its direction n turns towards the slide: dn/dt
 * = (I - n n) u/r for the rate u of the slide. The angle between n and u follows tan(angle/2) = tan(angle_0/2)
 * exp(-integral of |u|/r dt).
 *
 * If s is piecewise linear in x, it remains so after straight motion along one line: springs slip beyond one depth
 * (Cattaneo 1938, Mindlin and Deresiewicz 1953), where s = r n. With K = dF/dd and s(d) = 0,
 *     force = ratio * integral of s dK = -ratio * sum of (change of s / change of x) * (change of F),
 * which is the superposition of normal forces of Jaeger (1993) and Ciavarella (1998), for any elastic law. For a
 * rate-dependent law, F is its force at rate 0, and the bound is multiplied by the ratio of the whole force to F. */
#include "aoimpact.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define NONE {0.0, 0.0, 0.0, 0.0}

/* Largest number of times that an interval between two springs is halved in one step, into 64 parts at most. */
enum { MOST_PARTINGS = 6 };

/* Width of an interval, relative to its depth, below which the mean of the stiffnesses at its ends is more
 * accurate than the difference of the forces divided by the width. The value is the cube root of the rounding
 * error. */
static const double NARROW = 6e-6;

/* Smallest square from which length_of takes the root directly: it is far enough from underflow to keep its
 * digits. */
static const double LEAST_SQUARE = 1e-280;

/* Largest mu/ratio accepted; its square does not overflow. */
static const double STEEPEST = 1e140;

/* Value of tan(angle/2) for angles of 180 degrees; its square does not overflow. */
static const double STRAIGHT_BACK = 1e150;

/* Returns hypot(x, y), faster where squares neither overflow nor underflow. */
static double length_of(double x, double y)
{
    const double square = x * x + y * y;
    return square > LEAST_SQUARE && square < HUGE_VAL ? sqrt(square) : hypot(x, y);
}

/* A knot of the curve of stretches at the end of a path. by, s_by: derivatives of its depth and of its stretch
 * with respect to both slides, the indentation and the share. */
typedef struct knot {
    aoi_stretch at;
    double by[4], s_by[2][4];
    int slips;
} knot;

/* A straight path, and the state that it starts from. */
typedef struct path {
    int derive; /* 1: the knots' derivatives are computed */
    const aoi_friction *friction;
    const aoi_stretch *spring;
    aoi_stretch touch; /* the spring of depth 0 at the touch, if the path begins without contact */
    size_t count;
    double from, to, slide[2];
    double length, along[2]; /* length and direction of the slide; direction (0, 0) if the length is 0 */
    double first, slope; /* bound of the stretch divided by d - x, at start and end: mu/ratio times share */
} path;

int aoi_friction_create(aoi_friction *friction, const aoi_law *law, double mu, double ratio, double precision)
{
    if (!friction || aoi_law_check(law) != AOI_OK || !(mu >= 0.0 && mu < HUGE_VAL) ||
        !(ratio > 0.0 && ratio < HUGE_VAL) || !(mu / ratio <= STEEPEST) || !(precision > 0.0 && precision <= 0.1)) {
        return AOI_ERROR_ARGUMENT;
    }
    if (law->remember || law->turns || law->pulls) {
        return AOI_ERROR_FRICTION;
    }
    friction->law = *law;
    friction->law.compliance = 0.0;
    friction->law.limit = HUGE_VAL;
    friction->mu = mu;
    friction->ratio = ratio;
    friction->precision = precision;
    return AOI_OK;
}

static aoi_law_value normal(const aoi_friction *friction, double depth)
{
    aoi_law_value value;
    aoi_law_push(&friction->law, NULL, depth, 0.0, &value);
    return value;
}

/* Returns the part of a path that is in contact: all of the path, or what is left after the first touch. */
static path path_of(const aoi_friction *friction, const aoi_friction_state *state, double indentation, double share,
                    const double slide[2])
{
    const double slope = friction->mu / friction->ratio;
    path p = {.friction = friction, .spring = state->spring, .count = state->count, .from = state->indentation,
              .to = indentation, .slide = {slide[0], slide[1]}, .first = slope * state->share, .slope = slope * share};
    if (state->count == 0) {
        const double left = indentation > 0.0 ? indentation / (indentation - p.from) : 0.0;
        p.count = 1;
        p.touch.stiffness = normal(friction, DBL_MIN).stiffness;
        p.from = 0.0;
        p.slide[0] *= left;
        p.slide[1] *= left;
    }
    p.length = length_of(p.slide[0], p.slide[1]);
    for (int i = 0; i < 2 && p.length > 0.0; i++) {
        p.along[i] = p.slide[i] / p.length;
    }
    return p;
}

static aoi_stretch spring_of(const path *p, size_t i)
{
    return p->spring && p->from > 0.0 ? p->spring[i] : p->touch;
}

/* Returns the spring of a state at a depth between the springs i and i + 1, with interpolated stretch. */
static aoi_stretch between(const path *p, size_t i, double depth)
{
    const aoi_stretch a = spring_of(p, i), b = spring_of(p, i + 1);
    const double share = (depth - a.depth) / (b.depth - a.depth);
    const aoi_law_value at = normal(p->friction, depth);
    const aoi_stretch found = {depth, {a.along[0] + share * (b.along[0] - a.along[0]),
                                       a.along[1] + share * (b.along[1] - a.along[1])}, at.force, at.stiffness};
    return found;
}

/* Onset of a spring's slip. share: share of the path before the onset; radius: bound of the stretch at the onset,
 * m; x, y: components of the stretch there, along the slide and across it, m. */
typedef struct entry {
    double share, radius, x, y;
} entry;

static entry entry_of(double x, double y, double u, double r, double r_by)
{
    const double a = u * u - r_by * r_by, b = x * u - r * r_by, c = fmin(x * x + y * y - r * r, 0.0);
    const double root = sqrt(fmax(b * b - a * c, 0.0));
    double share = b > 0.0 ? -c / (b + root) : a != 0.0 ? (root - b) / a : 1.0;
    share = share > 0.0 ? fmin(share, 1.0) : 0.0;
    const entry found = {share, r + share * r_by, x + share * u, y};
    return found;
}

/* Sets k to the knot of a spring that slips at the end of the path, where its bound is r1 > 0. */
static void turn(const path *p, const aoi_stretch *spring, double r1, knot *k)
{
    const double r0 = fmax(p->first * (p->from - spring->depth), 0.0);
    const double u = p->length, size = u > 0.0 ? 1.0 : length_of(spring->along[0], spring->along[1]);
    const double *axis = u > 0.0 ? p->along : spring->along, e[2] = {axis[0] / size, axis[1] / size};
    const double along = spring->along[0] * e[0] + spring->along[1] * e[1];
    const double across = spring->along[1] * e[0] - spring->along[0] * e[1];
    const entry in = entry_of(along, across, u, r0, r1 - r0);
    /* A spring that is first touched on the path (r0 = 0) is stretched along the slide. */
    const double grown = r0 > 0.0 ? (r1 - in.radius) / in.radius : 0.0;
    const double mean = fabs(grown) > DBL_EPSILON ? log1p(grown) / grown : 1.0;
    const double rate = r0 > 0.0 ? (1.0 - in.share) / in.radius * mean : 0.0;
    const double turned = rate * u, left = exp(-turned), length = length_of(in.x, in.y);
    double f0 = in.x >= 0.0 ? (length > 0.0 ? in.y / (length + in.x) : 0.0)
                            : (in.y != 0.0 ? (length - in.x) / in.y : STRAIGHT_BACK);
    f0 = fmax(-STRAIGHT_BACK, fmin(f0, STRAIGHT_BACK));
    const double f = f0 * left, norm = 1.0 + f * f, cosine = (1.0 - f) * (1.0 + f) / norm, sine = 2.0 * f / norm;
    const double n[2] = {cosine * e[0] - sine * e[1], cosine * e[1] + sine * e[0]};
    k->at.along[0] = r1 * n[0];
    k->at.along[1] = r1 * n[1];
    if (!p->derive) {
        return;
    }
    /* Derivatives of the direction of slip with respect to the slide: through the onset of slip (by_entry), the
     * slide's direction (by_direction) and its length (rate). */
    double by_entry = 0.0, by_direction = u > 0.0 ? 1.0 / u : 0.0, cosine0 = 1.0, sine0 = 0.0;
    if (r0 > 0.0) {
        const double norm0 = 1.0 + f0 * f0;
        cosine0 = (1.0 - f0) * (1.0 + f0) / norm0;
        sine0 = 2.0 * f0 / norm0;
        by_entry = left * (norm0 / norm) * in.share / in.radius;
        /* (1 - left)/u (1 - f0 f)/norm, written with factors that stay finite as u tends to 0 */
        by_direction = rate * (turned > 0.0 ? -expm1(-turned) / turned : 1.0) * ((1.0 - f0 * f) / norm);
    }
    const double by_along = -by_entry * sine0 - sine * rate, by_across = by_entry * cosine0 + by_direction;
    const double turning[2] = {by_along * e[0] - by_across * e[1], by_along * e[1] + by_across * e[0]};
    const double t[2] = {-n[1], n[0]};
    for (int i = 0; i < 2; i++) {
        k->s_by[i][0] = r1 * t[i] * turning[0];
        k->s_by[i][1] = r1 * t[i] * turning[1];
        k->s_by[i][2] = p->slope * n[i];
        k->s_by[i][3] = p->friction->mu / p->friction->ratio * (p->to - spring->depth) * n[i];
    }
}

static double bound_of(const path *p, const aoi_stretch *at) { return p->slope * (p->to - at->depth); }

/* Returns a spring as it is at the end of the path if it sticks; slips_at then tells if it slips instead. */
static aoi_stretch stuck_at(const path *p, const aoi_stretch *spring)
{
    aoi_stretch at = *spring;
    at.along[0] += p->slide[0];
    at.along[1] += p->slide[1];
    return at;
}

static int slips_at(const path *p, const aoi_stretch *at)
{
    return length_of(at->along[0], at->along[1]) > bound_of(p, at) * (1.0 + 2.0 * DBL_EPSILON);
}

/* Sets k to the knot of a spring at the end of the path, whether the spring sticks or slips. */
static void move_to(const path *p, const aoi_stretch *spring, knot *k)
{
    k->at = stuck_at(p, spring);
    k->slips = slips_at(p, &k->at);
    if (k->slips) {
        k->at.along[0] = k->at.along[1] = 0.0;
    }
    if (p->derive) {
        memset(k->by, 0, sizeof k->by);
        memset(k->s_by, 0, sizeof k->s_by);
        k->s_by[0][0] = k->s_by[1][1] = k->slips ? 0.0 : 1.0;
    }
    if (k->slips && bound_of(p, spring) > 0.0) {
        turn(p, spring, bound_of(p, spring), k);
    }
}

/* The curve of stretches between two springs, which is a straight line at the path's start. If all springs in
 * between stick, the stretch at a distance z inside the rim is e - z g. The bound there is z times path.slope:
 * springs slip where a z^2 - 2 b z + c > 0. least, most: limits of z, m; depth: of the outer spring, m; root: of
 * b^2 - a c. */
typedef struct piece {
    double depth, least, most, g[2], e[2], a, b, c, root;
} piece;

static piece piece_of(const path *p, const aoi_stretch *inner, const aoi_stretch *outer)
{
    piece q = {outer->depth, p->to - outer->depth, p->to - inner->depth, {0.0, 0.0}, {0.0, 0.0}, 0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i < 2; i++) {
        q.g[i] = (outer->along[i] - inner->along[i]) / (outer->depth - inner->depth);
        q.e[i] = outer->along[i] + p->slide[i] + q.least * q.g[i];
    }
    q.a = q.g[0] * q.g[0] + q.g[1] * q.g[1] - p->slope * p->slope;
    q.b = q.e[0] * q.g[0] + q.e[1] * q.g[1];
    q.c = q.e[0] * q.e[0] + q.e[1] * q.e[1];
    q.root = sqrt(fmax(q.b * q.b - q.a * q.c, 0.0));
    return q;
}

/* Returns 1 if some springs between two slipping ones stick, for example because the bound has fallen with the
 * rate of the indentation. */
static int dips(const piece *q)
{
    return q->a > 0.0 && q->root > 0.0 && q->b > q->least * q->a && q->b < q->most * q->a;
}

/* Returns the knot at which slip begins (begins = 1) or ends (0) with increasing depth. The root is computed in a
 * form that keeps its digits where all of the slip is next to the rim. */
static knot front(const path *p, const piece *q, int begins)
{
    const double *e = q->e, *g = q->g;
    const double first = q->b > 0.0 ? q->c / (q->b + q->root) : q->a < 0.0 ? (q->b - q->root) / q->a : q->least;
    const double last = q->a > 0.0 ? (q->b + q->root) / q->a : q->most;
    const double z = fmax(q->least, fmin(begins ? first : last, q->most));
    const double at[2] = {e[0] - z * g[0], e[1] - z * g[1]}, size = length_of(at[0], at[1]);
    const double n[2] = {size > 0.0 ? at[0] / size : 0.0, size > 0.0 ? at[1] / size : 0.0};
    const double steepness = n[0] * g[0] + n[1] * g[1] + p->slope;
    const double per = steepness != 0.0 && size > 0.0 ? 1.0 / steepness : 0.0;
    const aoi_law_value law = normal(p->friction, p->to - z);
    knot k = {{p->to - z, {at[0], at[1]}, law.force, law.stiffness}, {-n[0] * per, -n[1] * per, p->slope * per,
              p->friction->mu / p->friction->ratio * z * per}, {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}}, 1};
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 4; j++) {
            k.s_by[i][j] += g[i] * k.by[j];
        }
    }
    return k;
}

/* Iterator over the knots at the end of a path: the springs, the borders between sticking and slipping springs,
 * and the rim. */
typedef struct walk {
    const path *p;
    size_t next;    /* index of the next spring                      */
    aoi_stretch last; /* the last spring, as it is at the path's start */
    int sticks, slips; /* sticks, slips: 1 if the last spring sticks, or slips; both 0 before the first */
    int pending;    /* number of knots still to be returned, the last ones of `after` */
    int done;
    knot after[2];
} walk;

/* Returns the knot at the rim of the contact, where springs are not stretched. */
static knot rim_of(const path *p, int slips)
{
    const aoi_law_value law = normal(p->friction, p->to);
    const knot rim = {{p->to, {0.0, 0.0}, law.force, law.stiffness}, {0.0, 0.0, 1.0, 0.0}, {NONE, NONE}, slips};
    return rim;
}

/* Returns 1 if the law is a straight line between two depths, so that springs in between have no stiffness. */
static int is_line(const aoi_stretch *a, const aoi_stretch *b)
{
    const double risen = a->force + b->stiffness * (b->depth - a->depth);
    return a->stiffness == b->stiffness && fabs(b->force - risen) <= 4.0 * DBL_EPSILON * b->force;
}

/* Returns 1 if the law is a straight line from the spring `before` to the end of the path, so that spring i has no
 * stiffness. */
static int is_untouched(const path *p, const aoi_stretch *before, size_t i)
{
    if (!(i < p->count && spring_of(p, i).depth < p->to && spring_of(p, i).stiffness == before->stiffness)) {
        return 0;
    }
    const knot rim = rim_of(p, 0);
    return is_line(before, &rim.at);
}

/* Sets k to the next knot; returns 0 after the last knot. Where the law is a straight line, no border between
 * sticking and slipping springs is sought. */
static int step(walk *w, knot *k)
{
    const path *p = w->p;
    if (w->pending > 0) {
        *k = w->after[2 - w->pending--];
        return 1;
    }
    if (w->done) {
        return 0;
    }
    while (w->next > 0 && is_untouched(p, &w->last, w->next)) {
        w->next++;
    }
    const int is_spring = w->next < p->count && spring_of(p, w->next).depth < p->to;
    aoi_stretch here = {p->to, {0.0, 0.0}, 0.0, 0.0};
    if (is_spring) {
        here = spring_of(p, w->next);
        move_to(p, &here, k);
    } else {
        w->done = 1;
        *k = rim_of(p, 0);
        if (p->to <= p->from) {
            here = between(p, w->next - 1, p->to);
            k->slips = length_of(here.along[0] + p->slide[0], here.along[1] + p->slide[1]) > 0.0;
        }
    }
    const int slips = k->slips;
    if (((w->sticks && slips) || (w->slips && (slips || is_spring))) &&
        !is_line(&w->last, &k->at)) {
        const piece q = piece_of(p, &w->last, &here);
        const int begins = w->sticks, both = w->slips && slips;
        if (!both || dips(&q)) {
            w->after[0] = front(p, &q, 1);
            w->after[1] = *k;
            w->pending = both ? 2 : 1;
            *k = front(p, &q, begins);
        }
    }
    w->sticks = !slips;
    w->slips = slips;
    w->last = here;
    w->next++;
    return 1;
}

/* Adds the force of the springs between two depths. Returns their mean stiffness, N/m: the difference of the
 * forces divided by the width or, in a narrow interval where that difference has lost its digits, the mean of the
 * stiffnesses at both ends. */
static double pull(double ratio, const aoi_stretch *a, const aoi_stretch *b, aoi_friction_value *value)
{
    const double width = b->depth - a->depth;
    const int narrow = width <= NARROW * b->depth;
    const double mean = narrow ? 0.5 * (a->stiffness + b->stiffness) : (b->force - a->force) / width;
    const double terms = narrow ? mean : b->force / width;
    for (int i = 0; i < 2; i++) {
        value->force[i] -= ratio * (b->along[i] - a->along[i]) * mean;
        value->terms += ratio * fabs(b->along[i] - a->along[i]) * terms;
    }
    return mean;
}

/* Adds the force of the springs between two knots, and the derivatives of that force. */
static void add(double ratio, const knot *a, const knot *b, aoi_friction_value *value)
{
    const double width = b->at.depth - a->at.depth;
    if (!(width > 0.0)) {
        return;
    }
    const double mean = pull(ratio, &a->at, &b->at, value);
    for (int i = 0; i < 2; i++) {
        const double slope = (b->at.along[i] - a->at.along[i]) / width;
        double by[4];
        for (int j = 0; j < 4; j++) {
            by[j] = (b->s_by[i][j] - a->s_by[i][j]) * mean +
                    slope * ((b->at.stiffness - mean) * b->by[j] - (a->at.stiffness - mean) * a->by[j]);
        }
        value->by_slide[i][0] -= ratio * by[0];
        value->by_slide[i][1] -= ratio * by[1];
        value->by_indentation[i] -= ratio * by[2];
        value->by_share[i] -= ratio * by[3];
    }
}

/* Returns the number of sticking springs before the first spring that slips or at which the law becomes a straight
 * line. The path changes the stretches of these springs by the slide alone. */
static size_t sticking(const path *p)
{
    size_t i = 0;
    for (; p->spring && p->from > 0.0 && i < p->count && p->spring[i].depth < p->to; i++) {
        const aoi_stretch at = stuck_at(p, &p->spring[i]);
        if (slips_at(p, &at) || (i > 0 && at.stiffness == p->spring[i - 1].stiffness)) {
            break;
        }
    }
    return i;
}

/* Starts an iteration over knots at the sticking spring next - 1 or, if next is 0, at the first spring. k: set to
 * the knot of this spring. */
static walk walk_from(const path *p, size_t next, knot *k)
{
    walk w = {.p = p, .next = next, .sticks = next > 0};
    if (next > 0) {
        w.last = spring_of(p, next - 1);
        move_to(p, &w.last, k);
    } else {
        (void)step(&w, k);
    }
    return w;
}

void aoi_friction_try(const aoi_friction *friction, const aoi_friction_state *state, double indentation,
                      double share, const double slide[2], aoi_friction_value *value)
{
    const aoi_friction_value none = {.stuck = 0.0};
    *value = none;
    if (!(indentation > 0.0)) {
        return;
    }
    path p = path_of(friction, state, indentation, share, slide);
    p.derive = 1;
    const size_t stuck = sticking(&p);
    for (size_t i = 1; i < stuck; i++) {
        const aoi_stretch inner = stuck_at(&p, &p.spring[i - 1]), outer = stuck_at(&p, &p.spring[i]);
        (void)pull(friction->ratio, &inner, &outer, value);
        value->stuck += outer.depth - inner.depth;
    }
    knot pair[2], *a = &pair[0], *b = &pair[1];
    walk w = walk_from(&p, stuck, a);
    int slips = 0;
    const double reach = (state->count > 0 ? state->reach : 0.0) + p.length;
    for (knot *before; step(&w, b); before = a, a = b, b = before) {
        const int slide_both = a->slips && (b->slips || !(b->at.depth < indentation));
        add(friction->ratio, a, b, value);
        value->stuck += slide_both ? 0.0 : b->at.depth - a->at.depth;
        slips = slips || slide_both;
    }
    value->stuck = slips ? value->stuck : indentation;
    /* The force has the rounding errors of bounds, which are differences of depths, and of stretches, which are
     * sums of many slides. A bound matters only if a stretch can reach it. */
    const double stretches = friction->ratio * reach * a->at.stiffness;
    value->terms += fmin(friction->mu * share * a->at.force, stretches) + stretches;
}

static void swap(aoi_friction_state *state, size_t count)
{
    aoi_stretch *other = state->spare;
    state->spare = state->spring;
    state->spring = other;
    state->count = count;
}

/* Returns the tolerance of the curve of stretches, m: `precision` times the smaller of the largest stretch since
 * the touch and the largest possible one. Unless all springs slip, the largest stretch before or after a slide is
 * at least half the slide. */
static double enough_of(const path *p, const aoi_friction_state *state)
{
    const double reach = fmax(state->count > 0 ? state->reach : 0.0, 0.5 * p->length);
    return p->friction->precision * fmin(reach, p->slope * p->to);
}

/* Copies the state's springs to its spare array, with an additional spring midway between two springs if the path
 * bends the curve between these. Returns the number of springs, or 0 if there is no room. */
static size_t parted(const aoi_friction_state *state, const path *p)
{
    const double enough = enough_of(p, state);
    size_t copied = 0, count = 0;
    knot a, b;
    walk w = walk_from(p, sticking(p), &a);
    for (; step(&w, &b); a = b) {
        const size_t outer = w.next - 1;
        if (!(a.slips && b.slips && b.at.depth > a.at.depth) || is_line(&a.at, &b.at)) {
            continue;
        }
        const aoi_stretch middle = between(p, outer - 1, 0.5 * (a.at.depth + b.at.depth));
        knot k;
        move_to(p, &middle, &k);
        if (fabs(k.at.along[0] - 0.5 * (a.at.along[0] + b.at.along[0])) > enough ||
            fabs(k.at.along[1] - 0.5 * (a.at.along[1] + b.at.along[1])) > enough) {
            if (state->count + (count - copied) + 1 > state->room) {
                return 0;
            }
            while (copied < outer) {
                state->spare[count++] = state->spring[copied++];
            }
            state->spare[count++] = middle;
        }
    }
    while (copied < state->count) {
        state->spare[count++] = state->spring[copied++];
    }
    return count;
}

int aoi_friction_refine(const aoi_friction *friction, aoi_friction_state *state, double indentation, double share,
                        const double slide[2])
{
    for (int i = 0; i < MOST_PARTINGS && state->count > 0 && indentation > 0.0; i++) {
        const path p = path_of(friction, state, indentation, share, slide);
        const size_t count = parted(state, &p);
        if (count == 0 || count == state->count) {
            return count == 0 ? AOI_ERROR_SPRINGS : AOI_OK;
        }
        swap(state, count);
    }
    return AOI_OK;
}

/* Returns 1 if spring b between a and c may be left out of the curve of stretches: the curve is nearly straight
 * there, or the law is, so that springs have no stiffness. (Change of slope) x width is four to eight times the
 * distance of the curve from its chord, whatever the spacing of the springs. Between close springs a change of
 * slope may be rounding of their depths. enough: tolerance of the curve, m; slope: ratio of the bound to d - x. */
static int straight(const aoi_stretch *a, const aoi_stretch *b, const aoi_stretch *c, double enough, double slope)
{
    if (is_line(a, b) && is_line(b, c)) {
        return 1;
    }
    const double rounding = 4.0 * DBL_EPSILON * slope * c->depth;
    const double before = b->depth - a->depth, after = c->depth - b->depth, width = c->depth - a->depth;
    for (int i = 0; i < 2; i++) {
        const double change = (c->along[i] - b->along[i]) * before - (b->along[i] - a->along[i]) * after;
        if (fabs(change) * width > enough * before * after && fabs(change) > rounding * width) {
            return 0;
        }
    }
    return 1;
}

/* Appends a spring to the spare array, and removes the spring before it if that is not needed. Returns 0 if there
 * is no room. Of two springs at one depth the later stays, as the rim replaces a spring. */
static int draw(aoi_friction_state *state, const path *p, double enough, const aoi_stretch *here, size_t *count)
{
    aoi_stretch *spring = state->spare;
    if (*count > 0 && !(here->depth > spring[*count - 1].depth)) {
        --*count;
    }
    if (*count > 1 && straight(&spring[*count - 2], &spring[*count - 1], here, enough, p->slope)) {
        --*count;
    }
    if (*count == state->room) {
        return 0;
    }
    spring[(*count)++] = *here;
    return 1;
}

int aoi_friction_move(const aoi_friction *friction, aoi_friction_state *state, double indentation, double share,
                      const double slide[2])
{
    size_t count = 0;
    double reach = 0.0;
    if (indentation > 0.0) {
        const path p = path_of(friction, state, indentation, share, slide);
        const double enough = enough_of(&p, state);
        const size_t stuck = sticking(&p);
        int fits = 1;
        for (size_t i = 0; i + 1 < stuck && fits; i++) {
            const aoi_stretch here = stuck_at(&p, &p.spring[i]);
            fits = draw(state, &p, enough, &here, &count);
            reach = fmax(reach, length_of(here.along[0], here.along[1]));
        }
        knot k;
        walk w = walk_from(&p, stuck, &k);
        for (int more = 1; more && fits; more = step(&w, &k)) {
            fits = draw(state, &p, enough, &k.at, &count);
            reach = fmax(reach, length_of(k.at.along[0], k.at.along[1]));
        }
        if (!fits) {
            return AOI_ERROR_SPRINGS;
        }
        reach = fmax(reach, state->count > 0 ? state->reach : 0.0);
    }
    swap(state, count);
    state->indentation = indentation;
    state->reach = reach;
    state->share = share;
    return AOI_OK;
}

double aoi_friction_energy(const aoi_friction *friction, const aoi_friction_state *state)
{
    double energy = 0.0;
    for (size_t i = 1; i < state->count; i++) {
        const aoi_stretch a = state->spring[i - 1], b = state->spring[i];
        const double width = b.depth - a.depth;
        const double work = aoi_law_potential(&friction->law, NULL, b.depth) -
                            aoi_law_potential(&friction->law, NULL, a.depth);
        for (int j = 0; j < 2; j++) {
            const double slope = (b.along[j] - a.along[j]) / width;
            energy -= friction->ratio * slope * (b.along[j] * b.force - a.along[j] * a.force - slope * work);
        }
    }
    return energy;
}
