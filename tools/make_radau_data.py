"""Write csrc/motion/radau.c: the constants of the collocation method, each the nearest double.

Usage: python tools/make_radau_data.py > csrc/motion/radau.c   (needs mpmath)
"""

from __future__ import annotations

import mpmath as mp

mp.mp.dps = 60

STAGES = 8
MOMENTS = 13  # AOI_RADAU_MOMENTS: z^(2m)/(2m)! at z = 3 is below 1e-15 beyond them
CHECKS = 10  # AOI_EDGE_CHECKS: a finer rule than that of the STAGES points at an edge


def shifted_legendre(n: int) -> list[mp.mpf]:
    """Monomial coefficients of P_n(2x-1)."""
    return [
        mp.mpf((-1) ** (n + k)) * mp.binomial(n, k) * mp.binomial(n + k, k) for k in range(n + 1)
    ]


def at(polynomial: list[mp.mpf], x: mp.mpf) -> mp.mpf:
    return sum((a * x**k for k, a in enumerate(polynomial)), mp.mpf(0))


def radau_nodes() -> list[mp.mpf]:
    """Roots of P_s - P_(s-1) on (0, 1], the last one being 1."""
    low = [*shifted_legendre(STAGES - 1), mp.mpf(0)]
    difference = [a - b for a, b in zip(shifted_legendre(STAGES), low, strict=True)]
    roots = mp.polyroots(difference[::-1], maxsteps=500, extraprec=400)
    return [*sorted(mp.re(r) for r in roots)[:-1], mp.mpf(1)]


def lagrange(points: list[mp.mpf], x: mp.mpf) -> list[mp.mpf]:
    """Values at x of the cardinal polynomials of the points."""
    return [
        mp.fprod((x - q) / (p - q) for j, q in enumerate(points) if j != i)
        for i, p in enumerate(points)
    ]


def to_legendre(points: list[mp.mpf]) -> list[list[mp.mpf]]:
    """Matrix from values at the points to coefficients of the shifted Legendre polynomials."""
    n = len(points)
    rows = [[at(shifted_legendre(k), x) for k in range(n)] for x in points]
    inverse = mp.matrix(rows) ** -1
    return [[inverse[k, j] for j in range(n)] for k in range(n)]


def cardinal_monomials(transform: list[list[mp.mpf]]) -> list[list[mp.mpf]]:
    """Monomial coefficients of the cardinal polynomials of the nodes."""
    result = []
    for j in range(STAGES):
        total = [mp.mpf(0)] * STAGES
        for k in range(STAGES):
            for q, a in enumerate(shifted_legendre(k)):
                total[q] += transform[k][j] * a
        result.append(total)
    return result


def series(power: int) -> list[mp.mpf]:
    """∫_0^1 (1-t)^n/n! P_l(t) dt of the shifted Legendre polynomials, zero for l > n."""
    f = mp.factorial
    return [
        (-1) ** degree * f(power) / (f(power - degree) * f(power + degree + 1))
        if degree <= power
        else mp.mpf(0)
        for degree in range(STAGES)
    ]


def on_part(c: mp.mpf, cardinal: list[list[mp.mpf]]) -> list[list[mp.mpf]]:
    """Coefficients t_lj of l_j(c x) = sum_l t_lj P_l(x)."""

    def coefficient(degree: int, polynomial: list[mp.mpf]) -> mp.mpf:
        return (2 * degree + 1) * sum(
            a * c**q * b / (q + r + 1)
            for q, a in enumerate(polynomial)
            for r, b in enumerate(shifted_legendre(degree))
        )

    return [
        [coefficient(degree, polynomial) for polynomial in cardinal] for degree in range(STAGES)
    ]


def extra_points(nodes: list[mp.mpf]) -> list[mp.mpf]:
    """Where the collocation equation does not hold: the nodes mirrored, among them the start.

    From there to the end of the step is as far as from its beginning to a node, so that what the
    bodies answer is in the tables already.
    """
    return [1 - x for x in nodes]


def slopes(points: list[mp.mpf], nodes: list[mp.mpf]) -> list[list[mp.mpf]]:
    """Derivatives at the nodes of the cardinal polynomials of the points."""
    return [
        [mp.diff(lambda x, i=i: lagrange(points, x)[i], c) for i in range(len(points))]
        for c in nodes
    ]


def extra_weights(nodes: list[mp.mpf], extra: list[mp.mpf]) -> list[mp.mpf]:
    """Weights of the extra points in the quadrature on them and the nodes together."""
    points = [*nodes, *extra]
    n = len(points)
    rows = [[mp.legendre(k, 2 * x - 1) for x in points] for k in range(n)]
    weights = mp.lu_solve(mp.matrix(rows), mp.matrix([1] + [0] * (n - 1)))
    return [weights[i] for i in range(STAGES, n)]


def edge_rule(count: int) -> tuple[list[mp.mpf], list[mp.mpf]]:
    """Gauss's rule in s, for the integral over x = s^2 on [0, 1]: points x and weights.

    A force that begins like x^(3/2) is smooth in s.
    """
    roots = sorted(
        mp.re(r) for r in mp.polyroots(shifted_legendre(count)[::-1], 500, extraprec=400)
    )
    rows = [[mp.legendre(k, 2 * s - 1) for s in roots] for k in range(count)]
    weights = mp.lu_solve(mp.matrix(rows), mp.matrix([1] + [0] * (count - 1)))
    return [s**2 for s in roots], [2 * s * weights[i] for i, s in enumerate(roots)]


def edge_points(count: int) -> list[list[mp.mpf]]:
    """The points near the start of the step, and, mirrored, near its end."""
    points = edge_rule(count)[0]
    return [points, [1 - x for x in points]]


def projection(nodes: list[mp.mpf], points: list[mp.mpf]) -> list[list[mp.mpf]]:
    """From values at the edge points to the values at the nodes of the nearest polynomial."""
    weights = edge_rule(len(points))[1]

    def one(c: mp.mpf, x: mp.mpf) -> mp.mpf:
        return sum(
            (2 * k + 1) * at(shifted_legendre(k), c) * at(shifted_legendre(k), x)
            for k in range(STAGES)
        )

    return [[w * one(c, x) for x, w in zip(points, weights, strict=True)] for c in nodes]


def by_columns(matrix: list[list[mp.mpf]]) -> list[list[mp.mpf]]:
    """Rows and columns exchanged: a product then runs along what lies side by side in memory."""
    return [list(column) for column in zip(*matrix, strict=True)]


def written(value: object) -> str:
    if isinstance(value, list):
        return "{" + ", ".join(written(v) for v in value) + "}"
    number = mp.mpf(value)
    return repr(float(number)) if abs(number) > mp.mpf(10) ** -40 else "0.0"


def declare(comment: str, declaration: str, value: object) -> None:
    text = f"const double aoi_radau_{declaration} = {written(value)};"
    print(f"\n/* {comment} */")
    line = ""
    for word in text.split(" "):
        if line and len(line) + len(word) > 118:
            print(line)
            line = "    "
        line += word if not line.strip() else f" {word}"
    print(line)


def declare_series(nodes: list[mp.mpf]) -> None:
    """Nodes, and the way to Legendre series and back."""
    declare("Radau IIA nodes.", "node[AOI_NODES]", nodes)
    declare(
        "From values at the nodes to Legendre coefficients.",
        "to_legendre[AOI_NODES][AOI_NODES]",
        to_legendre(nodes),
    )


def declare_moments(nodes: list[mp.mpf]) -> None:
    """What oscillators make of a polynomial force up to the nodes."""
    cardinal = cardinal_monomials(to_legendre(nodes))
    declare(
        "int_0^1 (1-x)^n/n! P_l(x) dx, by n.",
        "series[2 * AOI_RADAU_MOMENTS][AOI_NODES]",
        [series(n) for n in range(2 * MOMENTS)],
    )
    declare(
        "l_j(c x) = sum_l on_part[c][l][j] P_l(x), for each node c.",
        "on_part[AOI_NODES][AOI_NODES][AOI_NODES]",
        [on_part(c, cardinal) for c in nodes],
    )


def declare_extra(nodes: list[mp.mpf]) -> None:
    """The points beside the nodes at which the error is estimated."""
    extra, ends = extra_points(nodes), [mp.mpf(0), *nodes]
    declare(
        "Weights of the extra points, 1 - node, in the quadrature on these and the nodes.",
        "extra_weight[AOI_NODES]",
        extra_weights(nodes, extra),
    )
    declare(
        "There the polynomial that is 1 at the start and 0 at the nodes, and l_j, by columns.",
        "at_extra[AOI_NODES + 1][AOI_NODES]",
        by_columns([[lagrange(ends, x)[0], *lagrange(nodes, x)] for x in extra]),
    )
    declare(
        "Slopes at the nodes of the cardinal polynomials of 0 and the nodes, by columns.",
        "slope_at_node[AOI_NODES + 1][AOI_NODES]",
        by_columns(slopes(ends, nodes)),
    )


def declare_edges(nodes: list[mp.mpf]) -> None:
    """The points of a step that a contact begins or ends in, and those of its finer rule."""
    edges, checks = edge_points(STAGES), edge_points(CHECKS)
    ends = [mp.mpf(0), *nodes]
    declare("Points at an edge.", "edge_point[2][AOI_NODES]", edges)
    declare(
        "Cardinal polynomials of 0 and the nodes at the points of an edge, by columns.",
        "indentation_at_edge[2][AOI_NODES + 1][AOI_NODES]",
        [by_columns([lagrange(ends, x) for x in points]) for points in edges],
    )
    declare(
        "From values at the points of an edge to the nodes, by the nearest polynomial, by columns.",
        "edge_projection[2][AOI_NODES][AOI_NODES]",
        [by_columns(projection(nodes, points)) for points in edges],
    )
    declare(
        "Weights of the finer rule at an edge.",
        "check_weight[AOI_EDGE_CHECKS]",
        edge_rule(CHECKS)[1],
    )
    declare(
        "At its points the polynomial that is 1 at the start and 0 at the nodes, and l_j.",
        "at_check[2][AOI_EDGE_CHECKS][AOI_NODES + 1]",
        [[[lagrange(ends, x)[0], *lagrange(nodes, x)] for x in points] for points in checks],
    )


def main() -> None:
    nodes = radau_nodes()
    print("/* Made by tools/make_radau_data.py. Polynomials live on [0, 1]; l_j is the cardinal")
    print(" * polynomial of node j, P_k the shifted Legendre polynomial. */")
    print('#include "motion/radau.h"')
    for declare_part in (declare_series, declare_moments, declare_extra, declare_edges):
        declare_part(nodes)


if __name__ == "__main__":
    main()
