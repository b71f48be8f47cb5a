/* Newton's method for the normal and the tangential contact forces of one step together: the bodies couple them where a
 * normal force moves the surface sideways, and friction by Coulomb's bound. */
#include "law/oblique.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST_ITERATIONS = 100, MOST_HALVINGS = 30 };

/* Rounding of the sum of the equation's terms, as a share of these. */
static const double ROUNDING = 16.0 * DBL_EPSILON;

typedef struct point {
    double place[3], force[3], residual[3];
    double by[3][3], slope[3][3]; /* of the force and of the residual by the place */
    double size; /* of what of the residual is more than rounding */
    double stuck;
} point;

static void evaluate(const aoi_friction *friction, const aoi_friction_state *state, const aoi_oblique_equation *e,
                     point *p)
{
    aoi_law_value normal;
    aoi_friction_value friction_value;
    aoi_law_push(&friction->law, NULL, p->place[0], 0.0, &normal);
    aoi_friction_try(friction, state, p->place[0], &p->place[1], &friction_value);
    const double *f = friction_value.force, *g = friction_value.by_indentation;
    double (*s)[2] = friction_value.by_slide;
    const double force[3] = {normal.force, f[0], f[1]};
    const double by[3][3] = {{normal.stiffness, 0.0, 0.0}, {g[0], s[0][0], s[0][1]}, {g[1], s[1][0], s[1][1]}};
    memcpy(p->by, by, sizeof by);
    p->stuck = friction_value.stuck;
    p->size = 0.0;
    for (int i = 0; i < 3; i++) {
        double sum = 0.0, terms = fabs(p->place[i]) + fabs(e->free[i]);
        p->force[i] = force[i];
        for (int j = 0; j < 3; j++) {
            const double c = e->compliance[i][j];
            sum += c * force[j];
            terms += fabs(c) * (j > 0 ? friction_value.terms : normal.force);
            p->slope[i][j] = i == j;
            for (int k = 0; k < 3; k++) {
                p->slope[i][j] += e->compliance[i][k] * by[k][j];
            }
        }
        p->residual[i] = p->place[i] - e->free[i] + sum;
        /* Each to its own digits: slides may be much smaller than the indentation. */
        const double beyond = fabs(p->residual[i]) - ROUNDING * terms; /* NaN stays NaN */
        p->size += beyond <= 0.0 ? 0.0 : beyond * beyond;
    }
    p->size = sqrt(p->size);
}

static double determinant(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Solves slope x = right by Cramer's rule. */
static void solve(const point *p, const double right[3], double x[3])
{
    double column[3][3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            column[j][i] = p->slope[i][j];
        }
    }
    const double whole = determinant(column[0], column[1], column[2]);
    x[0] = determinant(right, column[1], column[2]) / whole;
    x[1] = determinant(column[0], right, column[2]) / whole;
    x[2] = determinant(column[0], column[1], right) / whole;
}

/* by_free = by slope^-1 */
static void give(const point *p, aoi_oblique_solution *solution)
{
    memcpy(solution->force, p->force, sizeof p->force);
    memcpy(solution->place, p->place, sizeof p->place);
    solution->stuck = p->stuck;
    for (int j = 0; j < 3; j++) {
        const double unit[3] = {j == 0, j == 1, j == 2};
        double x[3];
        solve(p, unit, x);
        for (int i = 0; i < 3; i++) {
            solution->by_free[i][j] = p->by[i][0] * x[0] + p->by[i][1] * x[1] + p->by[i][2] * x[2];
        }
    }
}

int aoi_oblique_solve(const aoi_friction *friction, const aoi_friction_state *state,
                      const aoi_oblique_equation *equation, aoi_oblique_solution *solution)
{
    point now;
    memcpy(now.place, equation->guess, sizeof now.place);
    evaluate(friction, state, equation, &now);
    for (int iteration = 0; !(now.size <= 0.0); iteration++) { /* NaN goes on */
        if (!isfinite(now.size)) {
            return isnan(now.force[0]) ? AOI_ERROR_LAW : AOI_ERROR_NOT_FINITE;
        }
        if (iteration == MOST_ITERATIONS) {
            return AOI_ERROR_NO_CONVERGENCE;
        }
        double change[3], share = 1.0;
        point next;
        solve(&now, now.residual, change);
        for (int halving = 0;; halving++, share *= 0.5) {
            for (int i = 0; i < 3; i++) {
                next.place[i] = now.place[i] - share * change[i];
            }
            evaluate(friction, state, equation, &next);
            if (next.size < now.size) {
                break;
            }
            if (halving == MOST_HALVINGS) {
                return AOI_ERROR_NO_CONVERGENCE;
            }
        }
        now = next;
    }
    give(&now, solution);
    return AOI_OK;
}
