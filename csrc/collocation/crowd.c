/* A step of very many contacts, coupled by the forces on the modes of their bodies. For N contacts of a body with
 * m modes the influence of all contact forces is A = S G P. P maps contact forces to forces on the modes, G maps
 * these to the motion of the modes (with a matrix over the nodes for each mode), and S maps the motion to
 * indentations. A product with A costs some 16 N m multiplications, the elimination of A (8 N)^3 / 3. Newton's
 * equations (1 + stiffness A + damping B) F = f, with B the influence on rates, are solved by GMRES (Saad and
 * Schultz 1986). The preconditioner is the inverse of the diagonal block of each force. The preconditioned matrix
 * couples forces by double integrals in time, whose spectrum clusters at zero: the iteration converges faster than
 * geometrically. Residual compliances couple forces directly. */
#include "collocation/collocation.h"
#include "collocation/newton.h"
#include "collocation/sliding.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "model/system.h"
#include "motion/nodes.h"
#include "motion/radau.h"

#include <math.h>
#include <string.h>

enum { SQUARE = AOI_NODES * AOI_NODES };

/* Largest number of GMRES vectors: enough for eight modes that contacts make stiff, with AOI_NODES vectors each. */
enum { VECTORS = 8 * AOI_NODES };

/* Equations of a step. Arrays with [2] are for indentations (index 0) and, if kinds = 2, for rates (1). */
typedef struct crowd {
    const aoi_system *system;
    const aoi_response *response;
    double h;
    size_t count, kinds;
    aoi_contact_step *entry;
    int bends;                           /* 1: residual compliances have an effect                                  */
    /* pushed: forces on the modes of all bodies at the nodes; used: 1 for a body on which such forces act; moved:
     * motion of the modes under these forces */
    double *pushed, *used, *moved[2];
    /* own: influence of each force on its own contact; inverse: inverses of the diagonal blocks of Newton's matrix */
    double *own[2], *inverse;
    double *stiffness, *damping;         /* slopes of the laws, of all entries at the nodes                        */
    /* reduction of indentations or rates due to the forces; right-hand side, then solution */
    double *effect[2], *right;
    double *basis, *triangle;            /* vectors of GMRES; its triangular matrix, by columns                    */
} crowd;

static crowd lay_out(const aoi_system *system, size_t count, double *work, size_t *size)
{
    const size_t modes = aoi_times(AOI_NODES, system->first[system->body_count]), rows = aoi_times(AOI_NODES, count);
    const size_t square = aoi_times(SQUARE, count);
    crowd made = {.system = system, .count = count};
    aoi_memory memory = {(char *)work, 0};
    double **part[] = {&made.pushed,    &made.moved[0], &made.moved[1],  &made.used,      &made.own[0],
                       &made.own[1],    &made.inverse,  &made.stiffness, &made.damping,   &made.effect[0],
                       &made.effect[1], &made.right,    &made.basis,     &made.triangle};
    const size_t room[] = {modes, modes, modes, system->body_count, square, square, square, rows, rows, rows, rows, rows,
                           aoi_times(VECTORS + 1, rows), VECTORS * VECTORS};
    for (size_t i = 0; i < sizeof room / sizeof *room; i++) {
        *part[i] = aoi_memory_doubles(&memory, room[i]);
    }
    *size = memory.used / sizeof(double);
    return made;
}

size_t aoi_crowd_size(const aoi_system *system)
{
    size_t size;
    (void)lay_out(system, aoi_system_forces(system), NULL, &size);
    return size;
}

int aoi_crowd_pays(const aoi_system *system)
{
    const double rows = AOI_NODES * (double)aoi_system_forces(system);
    const double half = fmin(rows, AOI_NODES * (1.0 + (double)aoi_system_span(system)));
    double modes = aoi_system_bends(system) ? rows / (2.0 * AOI_NODES) * (double)aoi_system_forces(system) : 0.0;
    for (size_t i = 0; i < 2 * system->contact_count; i++) {
        const aoi_contact *contact = &system->contact[i / 2];
        modes += (double)(aoi_contact_forces(contact) * system->body[contact->body[i % 2]].n);
    }
    return VECTORS * (2.0 * AOI_NODES * modes + VECTORS * rows) < rows * half * half / 3.0;
}

const double *aoi_crowd_motion(const aoi_system *system, size_t count, double *work)
{
    size_t size;
    return lay_out(system, count, work, &size).moved[0];
}

/* The body on one side of a contact, with the shape and push vectors of the contact's port. */
typedef struct touched {
    size_t body, n, first; /* index of the body; number of its modes; index of the first of these in the system */
    const double *shape, *push;
    double sign;
} touched;

static touched touched_by(const crowd *of, size_t s, int side)
{
    const aoi_contact *contact = &of->system->contact[of->entry[s].contact];
    const size_t b = contact->body[side];
    const aoi_modes *body = &of->system->body[b];
    const size_t at = (contact->port[side] + of->entry[s].axis) * body->n;
    return (touched){b, body->n, of->system->first[b], body->shape + at, body->push + at, side == 0 ? 1.0 : -1.0};
}

static const double *influence_of(const crowd *of, size_t b, size_t kind)
{
    return kind == 0 ? of->response[b].influence : of->response[b].influence_rate;
}

/* Finds the influence of each force on the indentation and rate of its own contact. */
static void find_own(const crowd *of)
{
    for (size_t s = 0; s < of->count; s++) {
        double *own[2] = {of->own[0] + s * SQUARE, of->own[1] + s * SQUARE};
        for (size_t kind = 0; kind < of->kinds; kind++) {
            memset(own[kind], 0, SQUARE * sizeof(double));
            for (int side = 0; side < 2; side++) {
                const touched at = touched_by(of, s, side);
                const double *influence = influence_of(of, at.body, kind);
                for (size_t j = 0; j < at.n; j++) {
                    aoi_vector_add(SQUARE, at.shape[j] * at.push[j], influence + j * SQUARE, own[kind]);
                }
            }
        }
        const size_t c = of->entry[s].contact;
        aoi_newton_add_residual(aoi_system_residual(of->system, c, c), of->h, own[0], of->kinds > 1 ? own[1] : NULL);
    }
}

/* Finds the motion of all modes of a body under the forces on these modes. */
static void move(const crowd *of, const touched *at)
{
    for (size_t j = 0; j < at->n; j++) {
        const size_t place = (at->first + j) * AOI_NODES;
        for (size_t kind = 0; kind < of->kinds; kind++) {
            aoi_nodes_multiply(influence_of(of, at->body, kind) + j * SQUARE, of->pushed + place, of->moved[kind] + place);
        }
    }
    of->used[at->body] = 0.0;
}

/* Finds the forces on the modes of all bodies due to the contact forces. */
static void push(const crowd *of, const double *force)
{
    for (size_t i = 0; i < 2 * of->count; i++) {
        const touched at = touched_by(of, i / 2, i % 2);
        double *pushed = of->pushed + at.first * AOI_NODES;
        if (of->used[at.body] == 0.0) {
            memset(pushed, 0, at.n * AOI_NODES * sizeof(double));
            of->used[at.body] = 1.0;
        }
        for (size_t j = 0; j < at.n; j++) {
            aoi_nodes_add(at.sign * at.push[j], force + i / 2 * AOI_NODES, pushed + j * AOI_NODES);
        }
    }
}

/* Adds the reduction of all indentations and rates due to the deflection of residual compliances under the contact
 * forces. */
static void bend(const crowd *of, const double *force)
{
    for (size_t t = 0; t < of->count; t++) {
        double slope[AOI_NODES];
        aoi_nodes_multiply(aoi_radau_slope_at_node[1], force + t * AOI_NODES, slope);
        for (size_t s = 0; s < of->count; s++) {
            const double residual = aoi_system_residual(of->system, of->entry[s].contact, of->entry[t].contact);
            aoi_nodes_add(residual, force + t * AOI_NODES, of->effect[0] + s * AOI_NODES);
            aoi_nodes_add(residual / of->h, slope, of->effect[1] + s * AOI_NODES);
        }
    }
}

/* Finds the reduction of all indentations and rates due to the contact forces. */
static void find_effect(const crowd *of, const double *force)
{
    push(of, force);
    memset(of->effect[0], 0, of->count * AOI_NODES * sizeof(double));
    memset(of->effect[1], 0, of->count * AOI_NODES * sizeof(double));
    for (size_t i = 0; i < 2 * of->count; i++) {
        const touched at = touched_by(of, i / 2, i % 2);
        if (of->used[at.body] != 0.0) {
            move(of, &at);
        }
        for (size_t kind = 0; kind < of->kinds; kind++) {
            const double *moved = of->moved[kind] + at.first * AOI_NODES;
            for (size_t j = 0; j < at.n; j++) {
                aoi_nodes_add(at.sign * at.shape[j], moved + j * AOI_NODES, of->effect[kind] + i / 2 * AOI_NODES);
            }
        }
    }
    if (of->bends) {
        bend(of, force);
    }
}

/* Multiplies by the preconditioned matrix of Newton's equations (see the top of this file):
 * y = D^-1 (1 + stiffness A + damping B) x, where D has one diagonal block for each force. */
static void multiply(const crowd *of, const double *x, double *y)
{
    find_effect(of, x);
    for (size_t s = 0; s < of->count; s++) {
        const aoi_contact_step *entry = &of->entry[s];
        const size_t axis = entry->axis, axes = entry->sliding ? 3 : 1, begins = s - axis, at = s * AOI_NODES;
        double sum[AOI_NODES], term[AOI_NODES];
        memcpy(sum, x + at, sizeof sum);
        for (size_t r = 0; r < axes; r++) {
            const double *by = entry->sliding ? entry->sliding->by[axis][r] : of->stiffness + at;
            aoi_collocation_weigh(entry->edge, by, of->effect[0] + (begins + r) * AOI_NODES, term);
            aoi_nodes_add(1.0, term, sum);
        }
        if (of->kinds > 1) {
            aoi_collocation_weigh(entry->edge, of->damping + at, of->effect[1] + at, term);
            aoi_nodes_add(1.0, term, sum);
        }
        aoi_nodes_multiply(of->inverse + s * SQUARE, sum, y + at);
    }
}

/* Reduces column k of the Hessenberg matrix to triangular form by Givens rotations, and rotates the right-hand
 * side likewise. below: last element of the column. Returns the norm of the residual. */
static double rotate(size_t k, double *column, double below, double (*turn)[2], double *right)
{
    for (size_t i = 0; i < k; i++) {
        const double upper = column[i], lower = column[i + 1];
        column[i] = turn[i][0] * upper + turn[i][1] * lower;
        column[i + 1] = turn[i][0] * lower - turn[i][1] * upper;
    }
    const double size = hypot(column[k], below);
    turn[k][0] = size > 0.0 ? column[k] / size : 1.0;
    turn[k][1] = size > 0.0 ? below / size : 0.0;
    column[k] = size;
    right[k + 1] = -turn[k][1] * right[k];
    right[k] *= turn[k][0];
    return fabs(right[k + 1]);
}

/* Replaces the right-hand side by the solution, by GMRES. The iteration ends when the residual is below `share`
 * times the right-hand side, or after VECTORS iterations. */
static void iterate(const crowd *of, double share)
{
    const size_t rows = of->count * AOI_NODES;
    double turn[VECTORS][2], right[VECTORS + 1], left, below;
    for (size_t s = 0; s < of->count; s++) {
        aoi_nodes_multiply(of->inverse + s * SQUARE, of->right + s * AOI_NODES, of->basis + s * AOI_NODES);
    }
    right[0] = left = below = sqrt(aoi_vector_dot(rows, of->basis, of->basis));
    size_t k = 0;
    for (const double enough = share * left; k < VECTORS && left > enough && below > 0.0; k++) {
        double *vector = of->basis + k * rows, *next = vector + rows, *column = of->triangle + k * VECTORS;
        for (size_t i = 0; i < rows; i++) {
            vector[i] /= below;
        }
        multiply(of, vector, next);
        for (size_t i = 0; i <= k; i++) {
            column[i] = aoi_vector_dot(rows, of->basis + i * rows, next);
            aoi_vector_add(rows, -column[i], of->basis + i * rows, next);
        }
        below = sqrt(aoi_vector_dot(rows, next, next));
        left = rotate(k, column, below, turn, right);
    }
    memset(of->right, 0, rows * sizeof(double));
    while (k-- > 0) {
        right[k] /= of->triangle[k * VECTORS + k];
        for (size_t i = 0; i < k; i++) {
            right[i] -= of->triangle[k * VECTORS + i] * right[k];
        }
        aoi_vector_add(rows, right[k], of->basis + k * rows, of->right);
    }
}

/* Sets the right-hand sides, the slopes of the laws and the inverses of the diagonal blocks. Returns 1, or 0 if
 * the equations of friction have no solution. */
static int set_equations(const crowd *of, const aoi_newton *newton)
{
    for (size_t s = 0; s < of->count; s++) {
        const aoi_contact_step *entry = &of->entry[s];
        aoi_law_values law;
        if (!aoi_newton_law(of->system, newton, entry, of->kinds > 1, &law)) {
            return 0;
        }
        const size_t at = s * AOI_NODES;
        const double *slope = entry->sliding ? entry->sliding->by[entry->axis][entry->axis] : law.stiffness;
        memcpy(of->stiffness + at, slope, sizeof law.stiffness);
        memcpy(of->damping + at, law.damping, sizeof law.damping);
        memcpy(of->right + at, law.force, sizeof law.force);
        aoi_newton_invert(entry->edge, slope, law.damping, of->own[0] + s * SQUARE,
                          of->kinds > 1 ? of->own[1] + s * SQUARE : NULL, of->inverse + s * SQUARE);
    }
    return 1;
}

int aoi_crowd_solve(const aoi_system *system, const aoi_response *response, double h, size_t count,
                    aoi_contact_step *entry, double *work)
{
    size_t size;
    crowd of = lay_out(system, count, work, &size);
    of.response = response;
    of.h = h;
    of.kinds = aoi_collocation_wants_rates(system, count, entry) ? 2 : 1;
    of.entry = entry;
    of.bends = aoi_system_bends(system);
    for (size_t i = 0; i < 2 * count; i++) { /* no forces act on any body so far */
        of.used[touched_by(&of, i / 2, i % 2).body] = 0.0;
    }
    find_own(&of);
    aoi_newton newton = aoi_newton_begin(count, entry);
    double change;
    int done;
    do {
        const int first = newton.iteration == 0;
        if (!set_equations(&of, &newton)) {
            return AOI_ERROR_NO_CONVERGENCE;
        }
        /* The relative error after this Newton step is the square of the last change: a smaller residual is not
         * needed. */
        iterate(&of, fmin(newton.before, AOI_NEWTON_KEPT));
        find_effect(&of, of.right);
        change = 0.0;
        for (size_t s = 0; s < count; s++) {
            const size_t at = s * AOI_NODES;
            change = aoi_newton_take(&entry[s], first, of.right + at, of.effect[0] + at,
                                     of.kinds > 1 ? of.effect[1] + at : NULL, change);
        }
        done = aoi_newton_done(&newton, change);
    } while (!done && aoi_newton_goes_on(&newton, change));
    for (size_t s = 0; s < count; s++) {
        memcpy(of.right + s * AOI_NODES, entry[s].force, sizeof entry[s].force);
    }
    find_effect(&of, of.right);
    return done ? AOI_OK : AOI_ERROR_NO_CONVERGENCE;
}
