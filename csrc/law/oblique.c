/* Newton's method for the normal and the tangential contact forces of one step together. These are coupled by
 * bodies whose surface a normal force moves sideways, and by Coulomb's bound on friction. */
#include "law/oblique.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST_ITERATIONS = 100, MOST_HALVINGS = 30 };

/* Rounding error of the sum of an equation's terms, relative to their magnitudes. */
static const double ROUNDING = 16.0 * DBL_EPSILON;

/* Largest residual, as a share of Coulomb's bound times the compliance, that is accepted as a jump of friction if
 * no Newton step reduces it. Where slipping springs all turn at once, even the smallest slide moves the border of
 * slip across many of them, and friction jumps by the error of its piecewise linear curve of stretches: up to 1e-4
 * of the bound was seen, whatever the step. */
static const double JUMP = 1e-3;

typedef struct point {
    double place[3], force[3], residual[3];
    double by[3][3], slope[3][3]; /* derivatives of forces and residuals with respect to indentation and slides */
    double by_rate[3];            /* derivative of the forces with respect to the rate */
    double size; /* norm of the residual above its rounding error, m */
    double stuck, share, rate;    /* as in aoi_oblique_solution */
} point;

/* Sets `inverse` to the inverse of a 3 x 3 matrix, stored by rows, by cofactors. */
static void invert(const double *a, double *inverse)
{
    for (int i = 0; i < 3; i++) {
        const double *up = a + 3 * ((i + 1) % 3), *down = a + 3 * ((i + 2) % 3);
        for (int j = 0; j < 3; j++) {
            const int left = (j + 1) % 3, right = (j + 2) % 3;
            inverse[3 * j + i] = up[left] * down[right] - up[right] * down[left];
        }
    }
    const double whole = a[0] * inverse[0] + a[1] * inverse[3] + a[2] * inverse[6];
    for (int i = 0; i < 9; i++) {
        inverse[i] /= whole;
    }
}

static double dot(const double x[3], const double y[3]) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; }

/* Sets `product` to a row vector times a 3 x 3 matrix. */
static void times(const double x[3], const double *matrix, double product[3])
{
    for (int j = 0; j < 3; j++) {
        product[j] = x[0] * matrix[j] + x[1] * matrix[3 + j] + x[2] * matrix[6 + j];
    }
}

/* Finds the forces at a place (indentation and two slides), and their derivatives. terms: set to the scales of the
 * forces' rounding errors, N. */
static void find_forces(const aoi_friction *friction, const aoi_friction_state *state, const aoi_oblique_equation *e,
                        const double rate_by[3], point *p, double terms[3])
{
    const aoi_law *law = &friction->law;
    aoi_law_value normal, rest;
    aoi_friction_value along;
    double share_by[3] = {0.0, 0.0, 0.0}, rates = fabs(e->rate_free), per = 0.0;
    p->share = 1.0;
    p->rate = e->rate_free;
    for (int j = 0; j < 3; j++) {
        p->rate += rate_by[j] * (p->place[j] - e->free[j]);
        rates += fabs(rate_by[j]) * (fabs(p->place[j]) + fabs(e->free[j]));
    }
    aoi_law_push(law, NULL, p->place[0], p->rate, &normal);
    for (int j = 0; j < 3; j++) {
        p->by[0][j] = (j == 0 ? normal.stiffness : 0.0) + normal.damping * rate_by[j];
    }
    if (law->depends_on_rate) {
        aoi_law_push(law, NULL, p->place[0], 0.0, &rest);
        per = rest.force > 0.0 ? 1.0 / rest.force : 0.0;
        p->share = per * normal.force;
        for (int j = 0; j < 3; j++) {
            share_by[j] = per * (p->by[0][j] - (j == 0 ? p->share * rest.stiffness : 0.0));
        }
    }
    aoi_friction_try(friction, state, p->place[0], p->share, &p->place[1], &along);
    p->force[0] = normal.force;
    p->by_rate[0] = normal.damping;
    for (int i = 0; i < 2; i++) {
        p->force[i + 1] = along.force[i];
        p->by_rate[i + 1] = along.by_share[i] * normal.damping * per;
        for (int j = 0; j < 3; j++) {
            p->by[i + 1][j] = (j == 0 ? along.by_indentation[i] : along.by_slide[i][j - 1]) +
                              along.by_share[i] * share_by[j];
        }
    }
    p->stuck = along.stuck;
    terms[0] = normal.force + fabs(normal.damping) * rates;
    terms[1] = terms[2] = along.terms + friction->mu * fabs(normal.damping) * rates;
}

static void evaluate(const aoi_friction *friction, const aoi_friction_state *state, const aoi_oblique_equation *e,
                     const double rate_by[3], point *p)
{
    double terms[3];
    find_forces(friction, state, e, rate_by, p, terms);
    p->size = 0.0;
    for (int i = 0; i < 3; i++) {
        double sum = 0.0, all = fabs(p->place[i]) + fabs(e->free[i]);
        /* all: scale of the rounding error of the residual. The indentation of the friction state counts too: at
         * the end of a contact free[0] may be 0, and the scale would be too small. */
        all += i == 0 ? fmax(state->indentation, 0.0) : 0.0;
        for (int j = 0; j < 3; j++) {
            const double c = e->compliance[i][j];
            sum += c * p->force[j];
            all += fabs(c) * terms[j];
            p->slope[i][j] = i == j;
            for (int k = 0; k < 3; k++) {
                p->slope[i][j] += e->compliance[i][k] * p->by[k][j];
            }
        }
        p->residual[i] = p->place[i] - e->free[i] + sum;
        /* The rounding of each residual is relative to the terms of its own equation, since slides may be much
         * smaller than the indentation. */
        const double beyond = fabs(p->residual[i]) - ROUNDING * all; /* NaN stays NaN */
        p->size += beyond <= 0.0 ? 0.0 : beyond * beyond;
    }
    p->size = sqrt(p->size);
}

/* Returns the largest residual that is accepted as a jump of friction, m. */
static double jump_of(const aoi_friction *friction, const aoi_oblique_equation *e, const point *p)
{
    return JUMP * friction->mu * p->force[0] * fmax(fabs(e->compliance[1][1]), fabs(e->compliance[2][2]));
}

/* Fills in the solution from the last iterate: by_free = by times the inverse of slope; by_rate follows from the
 * derivative of the forces with respect to the rate at constant indentation and slides. */
static void give(const aoi_oblique_equation *e, const point *p, aoi_oblique_solution *solution)
{
    double inverse[9], moved[3];
    invert(p->slope[0], inverse);
    for (int i = 0; i < 3; i++) {
        moved[i] = dot(e->compliance[i], p->by_rate);
        times(p->by[i], inverse, solution->by_free[i]);
    }
    for (int i = 0; i < 3; i++) {
        solution->by_rate[i] = p->by_rate[i] - dot(solution->by_free[i], moved);
    }
    memcpy(solution->force, p->force, sizeof p->force);
    memcpy(solution->place, p->place, sizeof p->place);
    solution->stuck = p->stuck;
    solution->share = p->share;
    solution->rate = p->rate;
}

int aoi_oblique_solve(const aoi_friction *friction, const aoi_friction_state *state,
                      const aoi_oblique_equation *equation, aoi_oblique_solution *solution)
{
    point now;
    /* rate_by: derivatives of the rate with respect to indentation and slides, with the forces eliminated */
    double inverse[9], rate_by[3] = {0.0, 0.0, 0.0};
    if (friction->law.depends_on_rate && equation->rate_compliance[0] > 0.0) {
        invert(equation->compliance[0], inverse);
        times(equation->rate_compliance, inverse, rate_by);
    }
    memcpy(now.place, equation->guess, sizeof now.place);
    evaluate(friction, state, equation, rate_by, &now);
    for (int iteration = 0; !(now.size <= 0.0); iteration++) { /* a NaN enters the loop, which returns an error */
        if (!isfinite(now.size)) {
            return isnan(now.force[0]) ? AOI_ERROR_LAW : AOI_ERROR_NOT_FINITE;
        }
        if (iteration == MOST_ITERATIONS) {
            return AOI_ERROR_NO_CONVERGENCE;
        }
        double share = 1.0;
        point next;
        invert(now.slope[0], inverse);
        for (int halving = 0;; halving++, share *= 0.5) {
            for (int i = 0; i < 3; i++) {
                next.place[i] = now.place[i] - share * dot(inverse + 3 * i, now.residual);
            }
            evaluate(friction, state, equation, rate_by, &next);
            if (next.size < now.size) {
                break;
            }
            if (halving == MOST_HALVINGS && now.size <= jump_of(friction, equation, &now)) {
                give(equation, &now, solution);
                return AOI_OK;
            }
            if (halving == MOST_HALVINGS) {
                return AOI_ERROR_NO_CONVERGENCE;
            }
        }
        now = next;
    }
    give(equation, &now, solution);
    return AOI_OK;
}

aoi_rub aoi_rub_of(const aoi_contact *contact)
{
    aoi_rub made = {.friction = *contact->friction, .compliance = {{contact->law->compliance}}};
    if (contact->compliance) {
        memcpy(made.compliance, contact->compliance, sizeof made.compliance);
    }
    return made;
}

int aoi_rub_solve(const aoi_rub *rub, const aoi_friction_state *state, aoi_oblique_equation *bodies,
                  aoi_oblique_solution *solution)
{
    for (size_t i = 0; i < 9; i++) {
        bodies->compliance[i / 3][i % 3] -= rub->compliance[i / 3][i % 3];
    }
    return aoi_oblique_solve(&rub->friction, state, bodies, solution);
}
