"""Write csrc/motion/radau.c: the constants of the collocation method, each the nearest double.

Usage: python tools/make_radau_data.py > csrc/motion/radau.c   (needs mpmath)
"""

from __future__ import annotations

import textwrap

import mpmath as mp
import numpy as np

mp.mp.dps = 60

STAGES = 8
MOMENTS = 13  # AOI_RADAU_MOMENTS, number of terms: from there on z^(2m)/(2m)! < 1e-15 at z = 3
CHECKS = 10  # AOI_EDGE_CHECKS, number of points of a rule finer than that of the STAGES at an edge

Row = list[mp.mpf]


def legendre(k: int, x: mp.mpf) -> mp.mpf:
    """Return the Legendre polynomial P_k(2x - 1), shifted to [0, 1]."""
    return mp.legendre(k, 2 * x - 1)


def gauss(n: int) -> Row:
    """Return the roots of P_n."""
    guesses = 0.5 + 0.5 * np.polynomial.legendre.leggauss(n)[0]
    return [mp.findroot(lambda x: legendre(n, x), mp.mpf(x)) for x in guesses]


def radau() -> Row:
    """Return the roots of P_s - P_(s-1) on (0, 1], of which the last is 1."""
    series = np.polynomial.Legendre([*(STAGES - 1) * [0.0], -1.0, 1.0], domain=[0.0, 1.0])

    def difference(x: mp.mpf) -> mp.mpf:
        return legendre(STAGES, x) - legendre(STAGES - 1, x)

    return [*(mp.findroot(difference, mp.mpf(x)) for x in series.roots()[:-1]), mp.mpf(1)]


def weights(points: Row) -> Row:
    """Return the weights of the quadrature on the points."""
    rows = [[legendre(k, x) for x in points] for k in range(len(points))]
    return list(mp.lu_solve(mp.matrix(rows), mp.matrix([1] + [0] * (len(points) - 1))))


def lagrange(points: Row, x: mp.mpf) -> Row:
    """Return the values at x of the cardinal polynomials of the points."""
    return [
        mp.fprod((x - q) / (p - q) for j, q in enumerate(points) if j != i)
        for i, p in enumerate(points)
    ]


def on_part(nodes: Row, c: mp.mpf) -> list[Row]:
    """Return the coefficients t_lj of l_j(c x) = sum_l t_lj P_l(x), by the nodes' exact rule."""
    rule = [(x, w, lagrange(nodes, c * x)) for x, w in zip(nodes, weights(nodes), strict=True)]
    return [
        [(2 * k + 1) * sum(w * at[j] * legendre(k, x) for x, w, at in rule) for j in range(STAGES)]
        for k in range(STAGES)
    ]


def series(power: int) -> Row:
    """Return ∫_0^1 (1-t)^n/n! P_l(t) dt for each l, n = `power`; zero for l > n."""
    f = mp.factorial
    return [
        (-1) ** degree * f(power) / (f(power - degree) * f(power + degree + 1))
        if degree <= power
        else mp.mpf(0)
        for degree in range(STAGES)
    ]


def slopes(points: Row, nodes: Row) -> list[Row]:
    """Return the derivatives at the nodes of the cardinal polynomials of the points."""
    return [
        [mp.diff(lambda x, i=i: lagrange(points, x)[i], c) for i in range(len(points))]
        for c in nodes
    ]


def edge_rule(count: int) -> tuple[list[Row], Row]:
    """Return points x = s^2 and weights of Gauss's rule in s, for integrals over x on [0, 1].

    A force that begins like x^(3/2) is smooth in s. The points are dense at the start of the step,
    and those of the second set, mirrored, at its end.
    """
    roots = gauss(count)
    points = [s**2 for s in roots]
    own = [2 * s * w for s, w in zip(roots, weights(roots), strict=True)]
    return [points, [1 - x for x in points]], own


def projection(nodes: Row, points: Row, rule: Row) -> list[Row]:
    """Return the matrix from values at edge points to the least-squares polynomial at the nodes."""

    def one(c: mp.mpf, x: mp.mpf) -> mp.mpf:
        return sum((2 * k + 1) * legendre(k, c) * legendre(k, x) for k in range(STAGES))

    return [[w * one(c, x) for x, w in zip(points, rule, strict=True)] for c in nodes]


def by_columns(matrix: list[Row]) -> list[Row]:
    """Return the transposed matrix, whose products run along contiguous memory."""
    return [list(column) for column in zip(*matrix, strict=True)]


def written(value: object) -> str:
    if isinstance(value, list):
        return "{" + ", ".join(written(v) for v in value) + "}"
    number = mp.mpf(value)
    return repr(float(number)) if abs(number) > mp.mpf(10) ** -40 else "0.0"


def declare(comment: str, declaration: str, value: object) -> None:
    text = f"const double aoi_radau_{declaration} = {written(value)};"
    how = {"subsequent_indent": "    ", "break_long_words": False, "break_on_hyphens": False}
    print(f"\n/* {comment} */", *textwrap.wrap(text, 119, **how), sep="\n")


def main() -> None:
    nodes = radau()
    # Points at which the residual of the collocation equation is checked: the mirrored nodes, with
    # the start. They are as far from the step's end as the nodes are from its start, so that
    # the bodies' responses over these times are in the tables already.
    extra, ends = [1 - x for x in nodes], [mp.mpf(0), *nodes]
    (edges, edge_weights), (checks, check_weights) = edge_rule(STAGES), edge_rule(CHECKS)

    print("/* Made by tools/make_radau_data.py. On [0, 1], l_j is the cardinal polynomial of node")
    print(" * j, P_k the shifted Legendre polynomial. An edge is an end of a step at which a force")
    print(' * begins ([0], the start) or ends ([1], the end). */\n#include "motion/radau.h"')
    declare("Radau IIA nodes.", "node[AOI_NODES]", nodes)
    declare(
        "Legendre coefficients (rows) of the polynomial through values at the nodes (columns).",
        "to_legendre[AOI_NODES][AOI_NODES]",
        on_part(nodes, mp.mpf(1)),
    )
    declare(
        "Integrals int_0^1 (1-x)^n/n! P_l(x) dx, in row n and column l.",
        "series[2 * AOI_RADAU_MOMENTS][AOI_NODES]",
        [series(n) for n in range(2 * MOMENTS)],
    )
    declare(
        "l_j(c x) = sum_l on_part[c][l][j] P_l(x), for each node c.",
        "on_part[AOI_NODES][AOI_NODES][AOI_NODES]",
        [on_part(nodes, c) for c in nodes],
    )
    declare(
        "Slopes at the nodes of the cardinal polynomials of start (0) and nodes, by columns.",
        "slope_at_node[AOI_NODES + 1][AOI_NODES]",
        by_columns(slopes(ends, nodes)),
    )
    declare("Quadrature points of edges; [2]: nodes.", "edge_point[3][AOI_NODES]", [*edges, nodes])
    declare(
        "Cardinal polynomials of start (0) and nodes at an edge's quadrature points, by columns.",
        "indentation_at_edge[2][AOI_NODES + 1][AOI_NODES]",
        [by_columns([lagrange(ends, x) for x in points]) for points in edges],
    )
    declare(
        "Nodal values of the least-squares fit to values at edge quadrature points, by columns.",
        "edge_projection[2][AOI_NODES][AOI_NODES]",
        [by_columns(projection(nodes, points, edge_weights)) for points in edges],
    )
    rest = (CHECKS - STAGES) * [mp.mpf(0)]
    declare(
        "Check points of a force against its polynomial: of a finer edge rule; [2]: 1 - node.",
        "check_point[3][AOI_EDGE_CHECKS]",
        [*checks, [*extra, *rest]],
    )
    declare(
        "Quadrature weights of the check points; [2]: in the rule on 1 - node and the nodes.",
        "check_weight[3][AOI_EDGE_CHECKS]",
        [check_weights, check_weights, [*weights([*nodes, *extra])[STAGES:], *rest]],
    )


if __name__ == "__main__":
    main()
