/* Products with matrices over the nodes of a step, and inversion of a matrix over the nodes. */
#include "motion/nodes.h"
#include "law/law.h"

enum { N = AOI_NODES };

/* Sums all columns in registers (vectorised over two or four rows). */
void aoi_nodes_multiply(const double *restrict column, const double *x, double *y)
{
    const double a = x[0], b = x[1], c = x[2], d = x[3], e = x[4], f = x[5], g = x[6], h = x[7];
    double sum[AOI_NODES];
    for (size_t i = 0; i < AOI_NODES; i++) {
        const double *at = column + i;
        sum[i] = (at[0] * a + at[N] * b + at[2 * N] * c + at[3 * N] * d) +
                 (at[4 * N] * e + at[5 * N] * f + at[6 * N] * g + at[7 * N] * h);
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        y[i] = sum[i];
    }
}

void aoi_nodes_multiply_from(double start, const double *column, const double *nodes, double *y)
{
    aoi_nodes_multiply(column + AOI_NODES, nodes, y);
    aoi_nodes_add(start, column, y);
}

/* Subtracts multiples of the pivot row from the rows first .. last - 1. Column k is replaced by column k of the
 * inverse. */
static void eliminate(size_t k, size_t first, size_t last, const double *restrict pivot_row,
                      double *restrict matrix)
{
    for (size_t i = first; i < last; i++) {
        double *row = matrix + i * AOI_NODES;
        const double factor = -row[k];
        aoi_nodes_add(factor, pivot_row, row);
        row[k] = factor * pivot_row[k];
    }
}

/* Gauss-Jordan elimination without pivoting. */
void aoi_nodes_invert(double *matrix)
{
    for (size_t k = 0; k < AOI_NODES; k++) {
        double pivot_row[AOI_NODES], *row = matrix + k * AOI_NODES;
        const double inverse = 1.0 / row[k];
        for (size_t q = 0; q < AOI_NODES; q++) {
            pivot_row[q] = row[q] * inverse;
        }
        pivot_row[k] = inverse;
        eliminate(k, 0, k, pivot_row, matrix);
        eliminate(k, k + 1, AOI_NODES, pivot_row, matrix);
        for (size_t q = 0; q < AOI_NODES; q++) {
            row[q] = pivot_row[q];
        }
    }
}
