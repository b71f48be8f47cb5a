/* AO models and rigid bodies as bodies in their natural modes. */
#include "linear/work.h"

#include <math.h>
#include <string.h>

typedef struct arrays {
    double *omega, *shape, *push, *inertia, *centre, *residual, *work;
} arrays;

static arrays lay_out(const aoi_star *star, void *block, size_t *size)
{
    aoi_memory memory = {block, 0};
    arrays made;
    double **of_modes[] = {&made.omega, &made.shape, &made.push, &made.inertia, &made.centre, &made.work};
    for (size_t i = 0; i < sizeof of_modes / sizeof *of_modes; i++) {
        *of_modes[i] = aoi_memory_doubles(&memory, star->n + 1);
    }
    made.residual = aoi_memory_doubles(&memory, 1);
    *size = memory.used;
    return made;
}

size_t aoi_star_modes_size(const aoi_star *star)
{
    size_t size;
    (void)lay_out(star, NULL, &size);
    return size;
}

/* Returns the compliance of a massless contact point while the oscillators do not move, m/N. */
static double massless_compliance(const aoi_star *star)
{
    double stiffness = star->k0;
    for (size_t i = 0; i < star->n; i++) {
        stiffness += star->k[i];
    }
    return 1.0 / stiffness;
}

/* Finds the displacement of the centre of mass in each mode, which is the ratio of momentum to mass. The momentum
 * of a constrained star changes by the force of the ground spring. */
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

/* ------------------------------------------------------------------------- in three directions */

/* Lays out the arrays of the bodies of three stars, and behind these the arrays of the whole body. */
static aoi_modes three_lay_out(const aoi_star *star, void *block, void *part[3], double **array, size_t *size)
{
    const size_t n = star[0].n + star[1].n + star[2].n + 3;
    aoi_memory memory = {block, 0};
    for (size_t i = 0; i < 3; i++) {
        part[i] = aoi_memory_take(&memory, 1, aoi_star_modes_size(&star[i]));
    }
    *array = aoi_memory_doubles(&memory, aoi_plus(aoi_times(9, n), 9));
    *size = memory.used;
    return (aoi_modes){.ports = 3};
}

size_t aoi_star_modes_of_three_size(const aoi_star star[3])
{
    size_t size;
    void *part[3];
    double *array;
    (void)three_lay_out(star, NULL, part, &array, &size);
    return size;
}

int aoi_star_modes_of_three(const aoi_star star[3], void *memory, aoi_modes *body)
{
    size_t size, at[3] = {0, 0, 0};
    void *part[3];
    double *array;
    aoi_modes of[3];
    *body = three_lay_out(star, memory, part, &array, &size);
    for (size_t i = 0; i < 3; i++) {
        const int status = aoi_star_modes(&star[i], part[i], &of[i]);
        if (status != AOI_OK) {
            return status;
        }
        body->n += of[i].n;
    }
    const size_t n = body->n;
    double *omega = array, *inertia = omega + n, *centre = inertia + n, *shape = centre + n, *push = shape + 3 * n;
    double *residual = push + 3 * n;
    memset(array, 0, (9 * n + 9) * sizeof *array);
    for (size_t k = 0; k < n; k++) { /* in the order of ascending frequency */
        size_t axis = 3;
        for (size_t i = 0; i < 3; i++) {
            if (at[i] < of[i].n && (axis == 3 || of[i].omega[at[i]] < of[axis].omega[at[axis]])) {
                axis = i;
            }
        }
        const size_t j = at[axis]++;
        omega[k] = of[axis].omega[j];
        inertia[k] = of[axis].inertia[j];
        centre[k] = axis == 0 ? of[axis].centre[j] : 0.0;
        shape[axis * n + k] = of[axis].shape[j];
        push[axis * n + k] = of[axis].push[j];
    }
    for (size_t i = 0; i < 3; i++) {
        residual[4 * i] = of[i].residual ? *of[i].residual : 0.0;
        body->residual = of[i].residual ? residual : body->residual;
    }
    body->omega = omega;
    body->inertia = inertia;
    body->centre = centre;
    body->shape = shape;
    body->push = push;
    return AOI_OK;
}

/* The velocity of the contact is velocity + angular velocity x arm, in right-handed axes. */
int aoi_rigid_modes(const aoi_rigid *rigid, double *memory, aoi_modes *body)
{
    enum { N = 6 };
    double *omega = memory, *inertia = omega + N, *centre = inertia + N, *shape = centre + N, *push = shape + 3 * N;
    memset(memory, 0, AOI_RIGID_ROOM * sizeof *memory);
    *body = (aoi_modes){.n = N, .ports = 3, .omega = omega, .shape = shape, .push = push};
    body->inertia = inertia;
    body->centre = centre;
    centre[0] = 1.0;
    for (size_t i = 0; i < 3; i++) {
        const size_t next = (i + 1) % 3, last = (i + 2) % 3;
        if (!(rigid->mass > 0.0 && isfinite(rigid->mass) && rigid->inertia[i] > 0.0 && isfinite(rigid->inertia[i]) &&
              isfinite(rigid->arm[i]))) {
            return AOI_ERROR_ARGUMENT;
        }
        inertia[i] = rigid->mass;
        inertia[3 + i] = rigid->inertia[i];
        shape[i * N + i] = 1.0;
        shape[i * N + 3 + next] = rigid->arm[last];
        shape[i * N + 3 + last] = -rigid->arm[next];
    }
    for (size_t k = 0; k < 3 * N; k++) {
        push[k] = shape[k] / inertia[k % N];
    }
    return AOI_OK;
}
