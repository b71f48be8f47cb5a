/* Krylov subspaces of chains, with solvers that may fail or lie. */
#include "dense.h"
#include "linear/krylov.h"
#include "linear/sparse.h"
#include "linear/vector.h"

enum { MOST = 8 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    const size_t n = take_between(&in, 1, MOST), ports = take_between(&in, 1, 3);
    const size_t capacity = take_below(&in, MOST + 3);
    const double *ground = take_array(&in, n, take_not_negative), *mass = take_array(&in, n, take_not_negative);
    const double *spring = take_array(&in, n, take_positive), *none = take_room(&in, n);
    aoi_krylov space = {.K = take_chain(&in, n, spring, ground), .M = take_chain(&in, n, none, mass)};
    space.s2 = take_byte(&in) % 8 ? take_positive(&in) : take_any(&in);
    chain_solver solver = take_solver(&in, &space.K, &space.M, 1.0, space.s2);
    space.solver = (aoi_residual_solver){chain_solve_with_products, &solver};
    space.port_count = ports;
    space.capacity = capacity;
    space.b = take_array(&in, n * ports, take_byte(&in) % 16 ? take_signed : take_any);
    space.basis = take_room(&in, n * capacity);
    space.stiffness = take_room(&in, capacity * capacity);
    space.load = take_room(&in, n);
    space.work = take_room(&in, aoi_krylov_work_size(n, capacity));
    for (int call = 0; call < 3; call++) {
        const size_t before = space.count;
        const int status = aoi_krylov_extend(&space, take_below(&in, MOST + 4));
        REQUIRE(space.count >= before && space.count <= capacity);
        REQUIRE(space.next + space.given_count <= ports + space.count);
        REQUIRE(aoi_vector_is_finite(n * space.count, space.basis));
        if (status != AOI_OK) {
            break;
        }
    }
    close_input(&in);
    return 0;
}
