/* Reference for the time of the core: a rigid sphere on an AO model (star) by Newmark's average
 * acceleration, in plain C - no record of velocities or energies, no other law, no massless contact. */
#include <math.h>
#include <stddef.h>

/* Returns the force hertz d^(3/2) at the root of d = free_end - compliance hertz d^(3/2), by Newton's
 * method from the last indentation, and sets the indentation d. */
static double force_at(double free_end, double compliance, double hertz, double *indentation)
{
    if (free_end <= 0.0) {
        *indentation = free_end;
        return 0.0;
    }
    double d = *indentation > 0.0 && *indentation < free_end ? *indentation : free_end;
    for (int i = 0; i < 50; i++) {
        const double root = sqrt(d);
        const double change = (d - free_end + compliance * hertz * root * d) /
                              (1.0 + 1.5 * compliance * hertz * root);
        d = d - change > 0.0 ? d - change : 0.5 * d;
        if (fabs(change) < 1e-15 * d) {
            break;
        }
    }
    *indentation = d;
    return hertz * sqrt(d) * d;
}

void newmark_star(size_t n, double m0, double k0, const double *m, const double *k, double mass,
                  double velocity, double hertz, double h, size_t steps, double *work, double *record)
{
    double *u = work, *v = work + n, *a = work + 2 * n, *w = work + 3 * n;
    const double reach = 0.25 * h * h;
    double inertia = m0 + reach * k0, u0 = 0.0, v0 = 0.0, a0 = 0.0, x = 0.0, s = velocity, b = 0.0;
    for (size_t i = 0; i < n; i++) {
        u[i] = v[i] = a[i] = 0.0;
        w[i] = k[i] / (m[i] + reach * k[i]);
        inertia += reach * m[i] * w[i];
    }
    const double compliance = reach / inertia + reach / mass;
    double indentation = 0.0;
    for (size_t step = 1; step <= steps; step++) {
        u0 += h * v0 + reach * a0;
        v0 += 0.5 * h * a0;
        double pull = k0 * u0;
        for (size_t i = 0; i < n; i++) {
            u[i] += h * v[i] + reach * a[i];
            v[i] += 0.5 * h * a[i];
            pull += m[i] * w[i] * (u0 - u[i]);
        }
        x += h * s + reach * b;
        s += 0.5 * h * b;
        const double free_end = x - (u0 - reach * pull / inertia);
        const double force = force_at(free_end, compliance, hertz, &indentation);
        a0 = (force - pull) / inertia;
        u0 += reach * a0;
        v0 += 0.5 * h * a0;
        for (size_t i = 0; i < n; i++) {
            a[i] = w[i] * (u0 - u[i]);
            u[i] += reach * a[i];
            v[i] += 0.5 * h * a[i];
        }
        b = -force / mass;
        x += reach * b;
        s += 0.5 * h * b;
        record[step] = force;
        record[steps + 1 + step] = indentation;
        record[2 * (steps + 1) + step] = x;
        record[3 * (steps + 1) + step] = u0;
    }
}
