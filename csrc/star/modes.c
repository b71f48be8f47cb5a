/* An AO model as a body in its natural modes. */
#include "linear/work.h"

#include <math.h>

typedef struct arrays {
    double *omega, *shape, *push, *inertia, *centre, *residual, *work;
} arrays;

static arrays lay_out(const aoi_star *star, void *block, size_t *size)
{
    aoi_memory memory = {block, 0};
    arrays made;
    made.omega = aoi_memory_doubles(&memory, star->n + 1);
    made.shape = aoi_memory_doubles(&memory, star->n + 1);
    made.push = aoi_memory_doubles(&memory, star->n + 1);
    made.inertia = aoi_memory_doubles(&memory, star->n + 1);
    made.centre = aoi_memory_doubles(&memory, star->n + 1);
    made.residual = aoi_memory_doubles(&memory, 1);
    made.work = aoi_memory_doubles(&memory, star->n);
    *size = memory.used;
    return made;
}

size_t aoi_star_modes_size(const aoi_star *star)
{
    size_t size;
    (void)lay_out(star, NULL, &size);
    return size;
}

/* Of a contact without mass, while the oscillators stand still. */
static double massless_compliance(const aoi_star *star)
{
    double stiffness = star->k0;
    for (size_t i = 0; i < star->n; i++) {
        stiffness += star->k[i];
    }
    return 1.0 / stiffness;
}

/* Momentum over mass: in a mode of a constrained star, the ground spring's force is what moves the mass. */
static void find_centre(const aoi_star *star, size_t n, const double *omega, const double *shape,
                        double *centre)
{
    const double mass = aoi_star_static_mass(star);
    for (size_t j = 0; j < n; j++) {
        centre[j] = star->k0 > 0.0 ? star->k0 * shape[j] / (omega[j] * omega[j] * mass)
                                   : (j == 0 ? shape[0] : 0.0);
    }
}

int aoi_star_modes(const aoi_star *star, void *memory, aoi_modes *body)
{
    size_t n = 1, size;
    const arrays made = lay_out(star, memory, &size);
    int status = aoi_star_check(star);
    if (status != AOI_OK) {
        return status;
    }
    if (isinf(star->m0)) {
        made.omega[0] = made.push[0] = made.inertia[0] = 0.0;
        made.shape[0] = made.centre[0] = 1.0;
    } else {
        status = aoi_star_to_modal(star, made.omega, made.shape, &n, made.work, NULL);
        for (size_t j = 0; j < n && status == AOI_OK; j++) {
            made.omega[j] = sqrt(made.omega[j]);
            made.push[j] = made.shape[j];
            made.inertia[j] = 1.0;
        }
        made.residual[0] = star->m0 > 0.0 ? 0.0 : massless_compliance(star);
        find_centre(star, n, made.omega, made.shape, made.centre);
    }
    *body = (aoi_modes){.n = n, .ports = 1, .omega = made.omega, .shape = made.shape, .push = made.push};
    body->residual = star->m0 > 0.0 ? NULL : made.residual;
    body->inertia = made.inertia;
    body->centre = made.centre;
    return status;
}
