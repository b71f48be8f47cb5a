/* The Krylov subspace of a rod of n elements (K = tridiag(-1, 2, -1), M = tridiag(1, 4, 1)/6 but for
 * its ends): its receptance at the shift, and as many derivatives as there are solves, against
 * elimination on the whole rod; breakdown where symmetry says so. */
#include "check.h"
#include "linear/krylov.h"
#include "linear/sparse.h"
#include "linear/vector.h"

#include <string.h>

enum { MOST = 40, PORTS = 3, WORK = 4 * MOST + MOST };

/* Free at both ends, or constrained at the first by one more spring. */
typedef struct rod {
    int n;
    int32_t start[MOST + 1], indices[3 * MOST];
    double k[3 * MOST], m[3 * MOST];
    double b[PORTS * MOST], basis[MOST * MOST], stiffness[MOST * MOST], load[MOST];
    double work[WORK];
    aoi_krylov space;
    double scale; /* of what the solver gives: 1 is right */
    int calls, fails_at;
} rod;

/* Gaussian elimination on the three diagonals of K + x M. */
static void rod_solve(const rod *r, double x, double *f)
{
    double pivot[MOST], beside[MOST];
    for (int i = 0; i < r->n; i++) {
        const int32_t at = r->start[i] + (i > 0);
        pivot[i] = r->k[at] + x * r->m[at];
        beside[i] = i + 1 < r->n ? r->k[at + 1] + x * r->m[at + 1] : 0.0;
        if (i > 0) {
            const double factor = beside[i - 1] / pivot[i - 1];
            pivot[i] -= factor * beside[i - 1];
            f[i] -= factor * f[i - 1];
        }
    }
    for (int i = r->n - 1; i >= 0; i--) {
        f[i] = (f[i] - (i + 1 < r->n ? beside[i] * f[i + 1] : 0.0)) / pivot[i];
    }
}

static int rod_solver(void *data, double *x, double *kx, double *mx)
{
    rod *r = data;
    rod_solve(r, r->space.s2, x);
    for (int i = 0; i < r->n; i++) {
        x[i] *= r->scale;
    }
    aoi_sparse_multiply(&r->space.K, x, kx);
    aoi_sparse_multiply(&r->space.M, x, mx);
    return ++r->calls == r->fails_at;
}

static void rod_make(rod *r, int n, int constrained, double s2, int ports)
{
    int32_t stored = 0;
    memset(r, 0, sizeof *r);
    r->n = n;
    r->scale = 1.0;
    for (int i = 0; i < n; i++) {
        const int first = i == 0, last = i == n - 1;
        r->start[i] = stored;
        for (int j = first ? i : i - 1; j <= i + !last; j++) {
            const int ends = first + last - (first && constrained);
            r->indices[stored] = j;
            r->k[stored] = i == j ? 2.0 - ends : -1.0;
            r->m[stored++] = i == j ? (4.0 - 2.0 * (first + last)) / 6.0 : 1.0 / 6.0;
        }
    }
    r->start[n] = stored;
    const size_t size = (size_t)n;
    r->space = (aoi_krylov){{size, r->start, r->indices, r->k}, {size, r->start, r->indices, r->m},
                            s2, {rod_solver, r}, (size_t)ports, 0, 0, size, r->b, r->basis,
                            r->stiffness, r->load, r->work, 0, 0, NULL};
}

/* b_p^T (K + x M)^-1 b_q. */
static double rod_receptance(const rod *r, int p, int q, double x)
{
    const size_t n = (size_t)r->n;
    double u[MOST];
    memcpy(u, r->b + (size_t)q * n, n * sizeof(double));
    rod_solve(r, x, u);
    return aoi_vector_dot(n, r->b + (size_t)p * n, u);
}

/* The same of the projected rod, by elimination on V^T K V + x. */
static double projected_receptance(const rod *r, int p, int q, double x)
{
    const size_t n = (size_t)r->n, count = r->space.count;
    double a[MOST][MOST], left[MOST], u[MOST], sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double *v = r->basis + i * n;
        for (size_t j = 0; j < count; j++) {
            a[i][j] = r->stiffness[i * r->space.capacity + j] + (i == j ? x : 0.0);
        }
        left[i] = aoi_vector_dot(n, r->b + (size_t)p * n, v);
        u[i] = aoi_vector_dot(n, r->b + (size_t)q * n, v);
    }
    for (size_t i = 0; i < count; i++) { /* positive definite: no pivoting */
        for (size_t row = i + 1; row < count; row++) {
            const double factor = a[row][i] / a[i][i];
            for (size_t j = i; j < count; j++) {
                a[row][j] -= factor * a[i][j];
            }
            u[row] -= factor * u[i];
        }
    }
    for (size_t i = count; i-- > 0;) {
        for (size_t j = i + 1; j < count; j++) {
            u[i] -= a[i][j] * u[j];
        }
        u[i] /= a[i][i];
        sum += left[i] * u[i];
    }
    return sum;
}

/* Also where the shift is far above the rod's modes and a new vector is all but the last again. */
static void basis_is_orthonormal_in_mass(void)
{
    for (int far = 0; far < 2; far++) {
        rod r;
        rod_make(&r, 30, 1, far ? 1e5 : 0.04, 1);
        r.b[29] = 1.0;
        CHECK(aoi_krylov_extend(&r.space, 8) == AOI_OK && r.space.count == 8, "8 solves");
        for (size_t i = 0; i < 8; i++) {
            double mv[MOST], kv[MOST];
            aoi_sparse_multiply(&r.space.M, r.basis + i * 30, mv);
            aoi_sparse_multiply(&r.space.K, r.basis + i * 30, kv);
            for (size_t j = 0; j < 8; j++) {
                const double mass = aoi_vector_dot(30, r.basis + j * 30, mv);
                const double stiff = aoi_vector_dot(30, r.basis + j * 30, kv);
                CHECK(fabs(mass - (i == j)) < 1e-14, "V^T M V is 1, not %g at %zu, %zu", mass, i, j);
                CHECK(fabs(stiff - r.stiffness[i * 30 + j]) < 1e-13, "V^T K V at %zu, %zu", i, j);
            }
        }
    }
}

/* Derivatives by differences of the error: it is of order (x - s^2)^(2 count). */
static void receptance_is_matched_at_the_shift(void)
{
    for (int constrained = 0; constrained < 2; constrained++) {
        for (size_t count = 1; count <= 4; count++) {
            rod r;
            rod_make(&r, 25, constrained, 0.5, 1);
            r.b[24] = 2.0;
            CHECK(aoi_krylov_extend(&r.space, count) == AOI_OK, "%zu solves", count);
            CHECK(near(projected_receptance(&r, 0, 0, 0.5), rod_receptance(&r, 0, 0, 0.5), 1e-14),
                  "the receptance at i s with %zu vectors", count);
            double error[2];
            for (int i = 0; i < 2; i++) {
                const double x = 0.5 + (i + 1) * 0.003 * (double)(count * count);
                error[i] = fabs(projected_receptance(&r, 0, 0, x) - rod_receptance(&r, 0, 0, x));
            }
            const double order = log(error[1] / error[0]) / log(2.0);
            CHECK(order > 2.0 * (double)count - 0.6, "%zu vectors: order %g", count, order);
        }
    }
}

static void growing_in_two_calls_is_growing_in_one(void)
{
    rod at_once, twice;
    rod_make(&at_once, 20, 1, 0.1, 1);
    rod_make(&twice, 20, 1, 0.1, 1);
    at_once.b[7] = twice.b[7] = 1.0;
    aoi_krylov_extend(&at_once.space, 9);
    aoi_krylov_extend(&twice.space, 4);
    CHECK(twice.calls == 4, "four vectors cost four solves, not %d", twice.calls);
    aoi_krylov_extend(&twice.space, 9);
    CHECK(twice.calls == 9, "five more cost five, not %d in all", twice.calls);
    CHECK(memcmp(at_once.basis, twice.basis, 9 * 20 * sizeof(double)) == 0, "the same vectors");
    CHECK(memcmp(at_once.stiffness, twice.stiffness, sizeof twice.stiffness) == 0, "as stiff");
}

/* Struck at its middle, a free rod of 2h+1 nodes moves symmetrically, in h+1 modes. (In longer rods
 * rounding adds vectors that b does not see.) */
static void symmetry_breaks_down(void)
{
    rod r;
    rod_make(&r, 9, 0, 0.3, 1);
    r.b[4] = 1.0;
    CHECK(aoi_krylov_extend(&r.space, 9) == AOI_OK, "breakdown is no error");
    CHECK(r.space.count == 5, "5 symmetric modes, not %zu", r.space.count);
    CHECK(r.calls == 6, "one solve finds nothing more, not %d", r.calls - 5);
    CHECK(near(projected_receptance(&r, 0, 0, 0.01), rod_receptance(&r, 0, 0, 0.01), 1e-10),
          "they are the rod, exactly");
    const size_t solves = r.space.next;
    CHECK(aoi_krylov_extend(&r.space, 9) == AOI_OK && r.space.next == solves, "and stay so");
    rod_make(&r, 21, 1, 0.3, 1);
    CHECK(aoi_krylov_extend(&r.space, 3) == AOI_OK && r.space.count == 0, "b = 0 excites nothing");
}

/* The free rod's translation 1/sqrt(mass), given, and taken out of b, is in the model exactly. */
static void rigid_motion_stays(void)
{
    rod r;
    rod_make(&r, 16, 0, 1e-10, 1); /* far below the first elastic mode */
    const double mass = 15.0;
    for (int i = 0; i < 16; i++) {
        const double share = i == 0 || i == 15 ? 0.5 : 1.0; /* M 1 */
        r.basis[i] = 1.0 / sqrt(mass);
        r.b[i] = (i == 15 ? 1.0 : 0.0) - share / mass;
    }
    r.space.rigid_count = r.space.given_count = r.space.count = 1;
    CHECK(aoi_krylov_extend(&r.space, 6) == AOI_OK && r.space.count == 6, "five solves");
    for (size_t j = 0; j < 6; j++) {
        CHECK(r.stiffness[j] == 0.0 && r.stiffness[j * 16] == 0.0, "it has no stiffness");
    }
    CHECK(near(projected_receptance(&r, 0, 0, 1e-3), rod_receptance(&r, 0, 0, 1e-3), 1e-9),
          "the elastic rest is right at low frequency");
}

/* The static mode, grown with s = 0 and then given: the receptance is right at 0 as well, and at the
 * shift every solve tells, none being spent on the static mode's own successor. */
static void static_mode_is_given(void)
{
    rod r;
    rod_make(&r, 24, 1, 0.0, 1);
    r.b[23] = 1.0;
    CHECK(aoi_krylov_extend(&r.space, 1) == AOI_OK && r.space.count == 1, "the static mode");
    r.space.given_count = 1;
    r.space.s2 = 0.5;
    r.space.next = 0;
    CHECK(aoi_krylov_extend(&r.space, 3) == AOI_OK && r.space.next == 2, "two solves");
    CHECK(near(projected_receptance(&r, 0, 0, 0.0), 24.0, 1e-12), "24 springs in a row");
    double error[2];
    for (int i = 0; i < 2; i++) {
        const double x = 0.5 + 0.03 * (i + 1);
        error[i] = fabs(projected_receptance(&r, 0, 0, x) - rod_receptance(&r, 0, 0, x));
    }
    const double order = log(error[1] / error[0]) / log(2.0);
    CHECK(order > 3.5, "two solves match four derivatives, not %g", order);
}

/* A given column of zeros is kept, and nothing else takes note of it. */
static void a_place_is_kept(void)
{
    for (int ports = 1; ports <= 2; ports++) {
        rod r, without;
        rod_make(&r, 24, 1, 0.2, ports);
        rod_make(&without, 24, 1, 0.2, ports);
        r.b[23] = without.b[23] = r.b[24 + 7] = without.b[24 + 7] = 1.0;
        r.space.given_count = r.space.count = 1;
        CHECK(aoi_krylov_extend(&r.space, 5) == AOI_OK && r.space.next == 4, "four solves");
        aoi_krylov_extend(&without.space, 4);
        CHECK(memcmp(r.basis + 24, without.basis, 4 * 24 * sizeof(double)) == 0, "the same vectors");
        for (size_t j = 0; j < 5; j++) {
            CHECK(r.stiffness[j] == 0.0 && r.stiffness[j * 24] == 0.0, "the place is empty");
        }
    }
}

/* Each port has its own chain of vectors: three each match six derivatives. */
static void every_port_is_matched_alike(void)
{
    rod r;
    rod_make(&r, 24, 1, 0.5, 2);
    r.b[23] = r.b[24 + 20] = 1.0;
    aoi_krylov_extend(&r.space, 6);
    for (int p = 0; p < 2; p++) {
        double error[2];
        for (int i = 0; i < 2; i++) {
            const double x = 0.5 + 0.03 * (i + 1);
            error[i] = fabs(projected_receptance(&r, p, p, x) - rod_receptance(&r, p, p, x));
        }
        const double order = log(error[1] / error[0]) / log(2.0);
        CHECK(order > 5.3, "port %d: order %g", p, order);
    }
}

static void two_shifts_are_both_matched(void)
{
    rod r;
    rod_make(&r, 24, 1, 2.0, 1);
    r.b[11] = 1.0;
    aoi_krylov_extend(&r.space, 2);
    r.space.s2 = 1e-3;
    aoi_krylov_extend(&r.space, 3);
    for (int i = 0; i < 2; i++) {
        const double x = i == 0 ? 2.0 : 1e-3;
        CHECK(near(projected_receptance(&r, 0, 0, x), rod_receptance(&r, 0, 0, x), 1e-13),
              "the receptance at s^2 = %g", x);
    }
}

static void bad_solvers_are_noticed(void)
{
    rod r;
    rod_make(&r, 12, 1, 0.1, 1);
    r.b[5] = 1.0;
    r.fails_at = 3;
    CHECK(aoi_krylov_extend(&r.space, 6) == AOI_ERROR_SOLVER, "it says that it failed");
    CHECK(r.space.count == 2 && r.space.next == 2, "two vectors are sound");
    CHECK(r.stiffness[1] != 0.0 && r.stiffness[1] == r.stiffness[12], "with their stiffness");
    CHECK(aoi_krylov_extend(&r.space, 6) == AOI_OK && r.space.count == 6, "and can be gone on from");
    rod_make(&r, 12, 1, 0.1, 1);
    r.b[5] = 1.0;
    r.scale = 1.005;
    CHECK(aoi_krylov_extend(&r.space, 6) == AOI_ERROR_SOLVER, "its solution is none");
    r.scale = 1.002;
    CHECK(aoi_krylov_extend(&r.space, 6) == AOI_OK, "a rough one is one");
    r.scale = (double)NAN;
    CHECK(aoi_krylov_extend(&r.space, 7) == AOI_ERROR_NOT_FINITE, "NaN is noticed");
}

static void bad_arguments_are_refused(void)
{
    rod r;
    rod_make(&r, 12, 1, 0.1, 1);
    CHECK(aoi_krylov_extend(&r.space, 13) == AOI_ERROR_ARGUMENT, "no room");
    r.space.rigid_count = r.space.given_count = 1;
    CHECK(aoi_krylov_extend(&r.space, 3) == AOI_ERROR_ARGUMENT, "rigid motions not yet there");
    r.space.given_count = 0;
    r.space.count = 1;
    CHECK(aoi_krylov_extend(&r.space, 3) == AOI_ERROR_ARGUMENT, "rigid motions are given");
    rod_make(&r, 12, 1, 0.1, 1);
    r.space.M.n = 11;
    CHECK(aoi_krylov_extend(&r.space, 3) == AOI_ERROR_ARGUMENT, "M of another size");
    CHECK(aoi_krylov_work_size(12, 12) == 60, "work space");
}

int main(void)
{
    basis_is_orthonormal_in_mass();
    receptance_is_matched_at_the_shift();
    growing_in_two_calls_is_growing_in_one();
    symmetry_breaks_down();
    rigid_motion_stays();
    static_mode_is_given();
    a_place_is_kept();
    every_port_is_matched_alike();
    two_shifts_are_both_matched();
    bad_solvers_are_noticed();
    bad_arguments_are_refused();
    return check_report();
}
