/* Sparse matrices and factors, for Python. */
#include "python/binding.h"
#include "linear/sparse.h"

void take_sparse(call *of, PyObject *tuple, size_t *n, aoi_sparse *matrix)
{
    size_t stored = ANY_LENGTH;
    TAKE(of, tuple, LONGER('i', matrix->start, *n, 1), ARRAY('i', matrix->indices, stored),
         ARRAY('d', matrix->values, stored));
    matrix->n = *n;
    if (of->status == AOI_OK) {
        of->status = aoi_sparse_check(matrix, stored);
    }
}

void take_factors(call *of, PyObject *tuple, size_t n, aoi_factors *factors)
{
    size_t stored = ANY_LENGTH;
    factors->n = n;
    factors->panel_count = ANY_LENGTH;
    TAKE(of, tuple, LONGER('i', factors->start, n, 1), ARRAY('i', factors->rows, stored),
         ARRAY('d', factors->values, stored), ARRAY('d', factors->pivots, n), ARRAY('i', factors->place, n),
         LONGER('i', factors->panel, factors->panel_count, 1));
    if (of->status == AOI_OK) {
        of->status = aoi_factors_check(factors, stored);
    }
}

PyObject *factors_find_panels(PyObject *args)
{
    call of = {.status = AOI_OK};
    aoi_sparse pattern = {.n = ANY_LENGTH};
    size_t stored = ANY_LENGTH, count = 0;
    int32_t *panel;
    TAKE(&of, args, LONGER('i', pattern.start, pattern.n, 1), ARRAY('i', pattern.indices, stored),
         LONGER('I', panel, pattern.n, 1));
    if (of.status == AOI_OK && (of.status = aoi_sparse_check(&pattern, stored)) == AOI_OK) {
        count = aoi_factors_find_panels(pattern.n, pattern.start, pattern.indices, panel);
    }
    return finish(&of, "factors", "n", (Py_ssize_t)count);
}
