/* Modes that oscillate many times within a step. The motion of such a mode is the sum of a polynomial, driven by
 * the step's forces, and a free oscillation from the state at the start. Both are known in closed form, and give a
 * bound of the oscillation's effect on a contact's force between the nodes, without sampling. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "model/system.h"
#include "motion/modes.h"
#include "motion/path.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/nodes.h"

#include <math.h>

/* Phase advance of a mode in a step, rad, above which the nodes do not resolve the mode. Below it, the last
 * coefficients of the series through start and nodes are as large as those left out: 3 |j_7(6)| against 19
 * |j_9(6)|, spherical Bessel functions of half the angle. Measured: 4 costs 6 % more work. */
static const double UNRESOLVED = 12.0;

static double decay_of(const aoi_modes *body, size_t j) { return body->decay ? body->decay[j] : 0.0; }

void aoi_step_series(const aoi_modes *body, const double *force, double h, double *series)
{
    const int some = body->n > 0 && body->omega[body->n - 1] * h > AOI_PATH_FAST;
    for (size_t p = 0; p < body->ports && some; p++) {
        aoi_nodes_to_legendre(force + p * AOI_NODES, series + p * AOI_NODES);
    }
}

int aoi_step_path(const aoi_adaptive *run, size_t b, size_t j, double h, int loaded, double *x, double *v)
{
    const aoi_modes *body = &run->system->body[b];
    const double *series = run->port_series + run->system->first_port[b] * AOI_NODES;
    double force[AOI_NODES] = {0.0}, place[AOI_NODES], rate[AOI_NODES];
    *x = *v = 0.0;
    if (loaded && (body->gravity || body->load.count > 0)) {
        aoi_modes_drive(body, j, aoi_run_now(run), &force[0], &force[1]);
        force[1] *= 0.5 * h;
        force[0] += force[1];
    }
    int moved = force[0] != 0.0 || force[1] != 0.0;
    for (size_t p = 0; p < body->ports; p++) {
        const double push = body->push[p * body->n + j];
        aoi_nodes_add(push, series + p * AOI_NODES, force);
        moved = moved || push != 0.0;
    }
    if (moved) {
        aoi_path_follow(body->omega[j], decay_of(body, j), h, force, place, rate);
        *x = aoi_legendre_at_start(place);
        *v = aoi_legendre_at_start(rate);
    }
    return moved;
}

/* Returns the amplitude of a mode's free oscillation at a port, m, at the step's start; damping only reduces it
 * later. */
static double amplitude_of(const aoi_adaptive *run, size_t b, size_t port, size_t j, double h)
{
    const aoi_modes *body = &run->system->body[b];
    const double share = fabs(body->shape[port * body->n + j]), omega = body->omega[j];
    const size_t at = run->system->first[b] + j;
    double x, v;
    if (share == 0.0 || !aoi_path_rings(omega, decay_of(body, j), h)) {
        return 0.0;
    }
    (void)aoi_step_path(run, b, j, h, 1, &x, &v);
    x -= run->x[at];
    v = (v - run->v[at]) / omega;
    return share * sqrt(x * x + v * v);
}

/* Terms of the response of a contact's force to a small oscillation of its indentation. stiffness, damping: slopes
 * of the law at the deepest node; compliance: residual compliance plus that of the fast modes of both bodies, m/N,
 * which reduces the response. */
typedef struct reaction {
    double stiffness, damping, compliance;
} reaction;

static reaction reaction_of(const aoi_adaptive *run, const aoi_contact_step *entry, double h)
{
    const aoi_contact *contact = &run->system->contact[entry->contact];
    const aoi_contact_step *normal = entry - entry->axis;
    aoi_law_value value;
    aoi_law_force(contact->law, entry->memory, aoi_step_piece(contact->law, normal), aoi_step_indentation(normal),
                  normal->start_rate, &value);
    reaction of = {value.stiffness, value.damping, aoi_system_residual(run->system, entry->contact, entry->contact)};
    of.stiffness *= entry->axis > 0 ? entry->sliding->rub.friction.ratio : 1.0;
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = &run->system->body[contact->body[side]];
        for (size_t j = body->n; j-- > 0 && body->omega[j] * h > AOI_PATH_FAST;) {
            const size_t at = (contact->port[side] + entry->axis) * body->n + j;
            of.compliance += body->shape[at] * body->push[at] / (body->omega[j] * body->omega[j]);
        }
    }
    return of;
}

/* Returns the amplitude of the force due to an oscillation of the indentation with the given amplitude, m, and
 * angular frequency, rad/s. */
static double force_of(const reaction *of, double amplitude, double omega)
{
    const double viscous = of->damping * omega, lossy = viscous * of->compliance;
    const double stiffer = 1.0 + fabs(of->stiffness) * of->compliance;
    return amplitude * sqrt((of->stiffness * of->stiffness + viscous * viscous) / (stiffer * stiffer + lossy * lossy));
}

double aoi_step_ring_growth(const aoi_adaptive *run, const aoi_contact_step *entry, double h, double growth,
                            double most)
{
    const aoi_contact *contact = &run->system->contact[entry->contact];
    const double longest = h * fmin(growth, AOI_MOST_GROWTH);
    reaction of = {0.0, 0.0, -1.0};
    for (int side = 0; side < 2; side++) {
        const size_t b = contact->body[side];
        const aoi_modes *body = &run->system->body[b];
        double sum = 0.0;
        for (size_t j = body->n; j-- > 0 && body->omega[j] * longest > UNRESOLVED;) {
            const double amplitude = amplitude_of(run, b, contact->port[side] + entry->axis, j, h);
            of = of.compliance < 0.0 && amplitude > 0.0 ? reaction_of(run, entry, h) : of;
            sum += force_of(&of, amplitude, body->omega[j]);
            if (!(sum <= 0.5 * most)) {
                growth = fmin(growth, UNRESOLVED / (body->omega[j] * h));
                break;
            }
        }
    }
    return growth;
}
