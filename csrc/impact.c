/* Two bodies and the law between them, step by step: predict both, solve the one contact equation,
 * correct both, write the record. */
#include "aoimpact.h"

#include <math.h>

static void write_body(const aoi_body *body, double *const *row, size_t column)
{
    aoi_observation seen = {0};
    body->observe(body, row[4] || row[5], &seen);
    const double value[AOI_ROW_BODY_COUNT] = {
        seen.displacement,    seen.velocity, seen.centre_displacement,
        seen.centre_velocity, seen.kinetic,  seen.elastic};
    for (int i = 0; i < AOI_ROW_BODY_COUNT; i++) {
        if (row[i]) {
            row[i][column] = value[i];
        }
    }
}

static void write_column(const aoi_impact *impact, double *const *row, size_t column, double force)
{
    if (row[AOI_ROW_FORCE]) {
        row[AOI_ROW_FORCE][column] = force;
    }
    if (row[AOI_ROW_INDENTATION]) {
        row[AOI_ROW_INDENTATION][column] = impact->indentation;
    }
    if (row[AOI_ROW_CONTACT_ENERGY]) {
        row[AOI_ROW_CONTACT_ENERGY][column] =
            impact->law->potential(impact->law, impact->indentation);
    }
    write_body(impact->projectile, row + AOI_ROW_BODY, column);
    write_body(impact->target, row + AOI_ROW_BODY + AOI_ROW_BODY_COUNT, column);
}

int aoi_impact_start(aoi_impact *impact, double *const *row)
{
    const double compliance = impact->projectile->compliance + impact->target->compliance;
    if (!(impact->gap >= 0.0) || !isfinite(impact->gap)) {
        return AOI_ERROR_ARGUMENT;
    }
    if (!(compliance > 0.0)) {
        return AOI_ERROR_NOT_POSITIVE; /* wall against wall: nothing can give way */
    }
    impact->indentation = impact->last_indentation = -impact->gap;
    write_column(impact, row, 0, 0.0);
    return AOI_OK;
}

static int impact_step(aoi_impact *impact, double *force)
{
    aoi_body *projectile = impact->projectile, *target = impact->target;
    double u_projectile, u_target, v_projectile, v_target, indentation;
    int status = projectile->predict(projectile, &u_projectile, &v_projectile);
    if (status == AOI_OK) {
        status = target->predict(target, &u_target, &v_target);
    }
    if (status != AOI_OK) {
        return status;
    }
    const aoi_contact_equation equation = {
        u_projectile - u_target - impact->gap,
        projectile->compliance + target->compliance,
        v_projectile - v_target,
        projectile->rate_compliance + target->rate_compliance,
        2.0 * impact->indentation - impact->last_indentation};
    status = aoi_contact_solve(impact->law, &equation, force, &indentation);
    if (status != AOI_OK) {
        return status;
    }
    projectile->correct(projectile, -*force);
    target->correct(target, *force);
    impact->last_indentation = impact->indentation;
    impact->indentation = indentation;
    return AOI_OK;
}

int aoi_impact_run(aoi_impact *impact, double *const *row, size_t first, size_t last, size_t *done)
{
    for (size_t column = first; column <= last; column++) {
        double force;
        const int status = impact_step(impact, &force);
        if (status != AOI_OK) {
            *done = column - 1;
            return status;
        }
        write_column(impact, row, column, force);
    }
    *done = last;
    return AOI_OK;
}
