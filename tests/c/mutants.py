"""Test the C tests: with any one of these formulas wrong, some program must fail.

    python3 mutants.py [compiler]

Each line of `MUTANTS` is a file of the core, a piece of its text, and what to put in its place. A
piece that has gone is an error: change the line here along with the formula. What only a sanitizer
would notice is not here.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

# s of processor time, which other work on the machine leaves alone; the longest of the programs
# takes four.
LONGEST = 20

HERE = Path(__file__).resolve().parent
CORE = HERE.parents[1] / "csrc"
PUBLIC = HERE.parents[1] / "include"

MUTANTS = [
    ("linear/vector.c", "i + 4 <= n; i += 4", "i + 4 < n; i += 5"),
    ("linear/vector.c", "y[i] += factor * x[i]", "y[i] -= factor * x[i]"),
    ("linear/sparse.c", "if (p < end) {", "if (p + 1 < end) {"),
    ("linear/sparse.c", "sum[(p - begin) & 1]", "sum[0]"),
    ("linear/sparse.c", "half[3] += value * x3[j]", "half[3] += value * x2[j]"),
    (
        "linear/sparse.c",
        "< 0 || (size_t)matrix->indices[p] >=",
        "< 0 || (size_t)matrix->indices[p] >",
    ),
    ("linear/sparse.c", "rows[p] <= (int32_t)j", "rows[p] < (int32_t)j"),
    ("linear/sparse.c", "!(factors->pivots[j] > 0.0)", "!(factors->pivots[j] >= 0.0)"),
    ("linear/sparse.c", "x[j + c] / factors->pivots[j + c]", "x[j + c]"),
    ("linear/sparse.c", "permuted[factors->place[i]] = x[i]", "permuted[i] = x[factors->place[i]]"),
    ("linear/sparse.c", "(v2[i] * y[2] + v3[i] * y[3])", "(v2[i] * y[2] - v3[i] * y[3])"),
    (
        "linear/sparse.c",
        "v0[i] * y[0] + v1[i] * y[1] + v2[i] * y[2];",
        "v0[i] * y[0] + v1[i] * y[1];",
    ),
    ("multigrid/block_rows.h", "sum += block[b * k + c] * x[c]", "sum += block[b * c + k] * x[c]"),
    (
        "multigrid/block_rows.h",
        "r[k] -= block[b * c + k] * x[c]",
        "r[k] -= block[b * k + c] * x[c]",
    ),
    ("multigrid/block_rows.h", "r[k] -= block[b * c + k] * x[c]", ""),
    (
        "multigrid/block_rows.h",
        "OF(minus)(OF(minus)(OF(minus)(other, b0, x0), b1, x1)",
        "OF(minus)(OF(minus)(other, b0, x0)",
    ),
    ("multigrid/block_rows.h", "OF(plus)(sum[1], b1, part)", "OF(plus)(sum[1], b0, part)"),
    ("multigrid/block_rows.h", "terms[0] + terms[1] + terms[2]", "terms[0] + terms[1]"),
    (
        "multigrid/blocks.c",
        "matrix->size > AOI_BLOCKS_WIDEST",
        "matrix->size > AOI_BLOCKS_WIDEST + 1",
    ),
    ("multigrid/blocks.c", "indices[q] <= i", "indices[q] < i"),
    ("multigrid/blocks.c", "(indices[q] >= n)", "(indices[q] > n)"),
    ("multigrid/blocks.c", "wrong || p >= end", "wrong"),
    ("multigrid/blocks.c", "row + 1 == matrix->n && diagonal + 1 != stored_count", "0"),
    ("multigrid/blocks.c", "stage > steps", "stage > steps + 1"),
    (
        "multigrid/block_rows.h",
        "OF(plus)(sum[k], OF(load)(values",
        "OF(minus)(sum[k], OF(load)(values",
    ),
    (
        "multigrid/block_rows.h",
        "p < diagonal; p++) {\n        OF(along)",
        "p < 0; p++) {\n        OF(along)",
    ),
    ("multigrid/blocks.c", "of[k] = -of[k];", ""),
    ("multigrid/blocks.c", "matrix->order[row], 0, width", "matrix->order[row], 0, 0 * width"),
    (
        "multigrid/blocks.c",
        "1.0 / (2.0 * middle / half - before)",
        "1.0 / (2.0 * middle / half + before)",
    ),
    ("multigrid/blocks.c", ".add = (float)(2.0 * rho / half)", ".add = (float)(rho / half)"),
    ("multigrid/blocks.c", "(float)(2.0 / (high + low))", "(float)(1.0 / high)"),
    ("multigrid/blocks.c", "if (finish) {", "if (!finish) {"),
    ("multigrid/blocks.c", "low > 0.0 && high > low", "low > 0.0 && high >= low"),
    ("multigrid/aggregate.c", "aggregate[indices[p]] != FREE", "aggregate[indices[p]] == FREE"),
    ("multigrid/aggregate.c", "aggregate[indices[p]] >= 0", "aggregate[indices[p]] != FREE"),
    ("multigrid/aggregate.c", "i, count++", "i, count"),
    ("multigrid/aggregate.c", "if (aggregate[i] < FREE) {", "if (aggregate[i] < FREE - 1) {"),
    ("star/reduce.c", "*stiffness = 1.0 / compliance", "*stiffness = compliance"),
    ("star/reduce.c", "phi_st[i] /= reach", "phi_st[i] /= sqrt(reach)"),
    ("star/reduce.c", "*mass = 1.0 / reach", "*mass = reach"),
    ("star/reduce.c", "reach > 1e4 * DBL_EPSILON", "reach > 1e-9 * DBL_EPSILON"),
    ("star/reduce.c", "pass < 2", "pass < 1"),
    ("star/reduce.c", "b[0] < 0.0 ? -1.0 : 1.0", "b[0] < 0.0 ? 1.0 : -1.0"),
    ("star/reduce.c", "sqrt(aoi_vector_dot(n, h, h) / 2.0)", "sqrt(aoi_vector_dot(n, h, h))"),
    ("star/reduce.c", "-0.5 * aoi_vector_dot(n, h, work)", "0.5 * aoi_vector_dot(n, h, work)"),
    ("star/reduce.c", "mass = coupling * coefficient[j]", "mass = coupling * coupling"),
    (
        "star/reduce.c",
        "stiffness = omega2[j] * mass",
        "stiffness = sqrt(omega2[j]) * mass",
    ),
    ("linear/krylov.c", "BREAKDOWN = 1e-11", "BREAKDOWN = 1e-17"),
    ("linear/krylov.c", "MOST_RESIDUAL = 3e-3", "MOST_RESIDUAL = 1e-2"),
    ("linear/krylov.c", "NO_CANCELLATION = 0.5", "NO_CANCELLATION = 1e-16"),
    ("linear/krylov.c", "space->given_count + turn - space->port_count", "space->count - 1"),
    ("linear/krylov.c", "source = space->given_count + ", "source = space->rigid_count + "),
    ("linear/krylov.c", "f[i] - kx[i] - space->s2 * mx[i]", "f[i] - kx[i]"),
    ("linear/krylov.c", "j < space->rigid_count ? 0.0 :", "0 ? 0.0 :"),
    ("linear/krylov.c", "x[i] /= length", "x[i] *= 1.0"),
    ("linear/krylov.c", "space->next++;", ""),
    ("linear/krylov.c", "copy(n, mx, space->load);", ""),
    ("linear/krylov.c", "space->port_count > 1", "space->port_count > 2"),
    ("linear/krylov.c", "NOTHING = 1e-13", "NOTHING = 10.0"),
    ("linear/krylov.c", "first += TOGETHER", "first += TOGETHER + 1"),
    (
        "linear/krylov.c",
        "project_stiffness(space, first);",
        "project_stiffness(space, space->count);",
    ),
    (
        "linear/krylov.c",
        "space->port_count + space->count) {",
        "space->port_count + space->count + 1) {",
    ),
    ("star/secular.c", "moved <= 2.0 * DBL_EPSILON * fabs(x)", "moved <= 1e-13 * fabs(x)"),
    ("star/secular.c", "*slope = s->linear + sum + x * sum_of_squares", "*slope = s->linear"),
    ("star/secular.c", "(s->pole[j] - origin) - offset", "s->pole[j] - (origin + offset)"),
    ("star/secular.c", "gap == last || value >= 0.0", "gap == last || value < 0.0"),
    ("star/secular.c", "if (!(right > left))", "if (right < left)"),
    ("star/star.c", "1.0 / (star->k0 - x * inertia)", "1.0 / (star->k0 + x * inertia)"),
    ("star/star.c", "return star->m0 + sum", "return sum"),
    ("star/star.c", "u[i + 1] - u[0]", "u[i + 1] + u[0]"),
    ("star/star.c", "star->k0 * u[0] * u[0]", "0.0 * u[0]"),
    ("star/star.c", "mass += star->m[i] * gain * gain", "mass += star->m[i] * gain"),
    ("star/star.c", "if (!isinf(mass))", "if (1)"),
    ("star/star.c", "hypot(root, sqrt(star->m[i]) * gain)", "hypot(root, gain)"),
    ("star/star.c", "*m0 = 1.0 / inverse_mass", "*m0 = inverse_mass"),
    ("star/star.c", "1.0 / (antiresonance * slope)", "1.0 / slope"),
    ("star/star.c", "star->m[i] <= 0.0 ||", "star->m[i] < 0.0 ||"),
    ("star/star.c", "weight[j] <= 0.0", "weight[j] < 0.0"),
    ("law/elastic.c", "*stiffness = 1.5 * k * root", "*stiffness = 1.4 * k * root"),
    ("law/elastic.c", "0.4 * law->parameter[0] * d * d", "0.5 * law->parameter[0] * d * d"),
    ("law/elastic.c", "/ (n + 1.0)", "/ n"),
    ("law/elastic.c", "n * slope;", "slope;"),
    ("law/elastic.c", "0.5 * law->parameter[0] * indentation", "law->parameter[0] * indentation"),
    ("law/law.c", "p < kind->least[i]", "0"),
    ("law/law.c", "&& !(p > 0.0)", "&& 0"),
    ("law/law.c", "                return AOI_ERROR_PATCH;", "                return AOI_OK;"),
    ("law/law.c", "value->damping *= stiffer", "value->damping *= 1.0"),
    ("law/law.c", "if (there.stiffness < value->stiffness) {", "if (0) {"),
    ("law/law.c", "beyond * value->stiffness / (1.0 - MOST_SHARE)", "beyond * value->stiffness"),
    ("law/law.c", "2.0 * DBL_EPSILON * fmax(fabs(*d), fabs(indentation))", "1e-9 * fabs(*d)"),
    ("law/law.c", "fmax(fabs(*d), fabs(indentation))", "fabs(*d)"),
    ("law/law.c", "LAW_NOISE = 1e-6", "LAW_NOISE = 0.1"),
    ("law/law.c", "LAW_NOISE = 1e-6", "LAW_NOISE = 1e-12"),
    ("law/law.c", "fabs(missing) <= LAW_NOISE * fmax(fabs(*d), fabs(indentation))", "1"),
    ("law/law.c", "return AOI_NO_PIECE;", "return piece;"),
    ("law/law.c", "law->compliance * value.stiffness < MOST_SHARE ? end", "1 ? end"),
    ("law/law.c", "&& *high < HUGE_VAL) {", ") {"),
    ("law/law.c", "!law->alone || law->compliance != 0.0", "!law->alone"),
    ("law/law.c", "return value.force < 0.0 && !law->pulls", "return value.force < 0.0"),
    ("law/law.c", "law->note[2] = AOI_ERROR_LAW_JUMPS", "law->note[2] = AOI_ERROR_LAW"),
    ("law/law.c", "rising ? 64.0 : -64.0", "rising ? -64.0 : 64.0"),
    ("law/law.c", "if (value->force < 0.0 && !law->pulls)", "if (value->force < 0.0)"),
    ("law/law.c", "!(indentation > aoi_law_rest(law, memory))", "indentation <= 0.0"),
    ("law/law.c", "- 0.5 * law->compliance * value.force", "- 0.0 * value.force"),
    ("law/law.c", "past * (end.force + 0.5 * end.stiffness * past)", "0.0"),
    ("law/law.c", "law->note[0] = indentation", "law->note[0] = rate"),
    ("law/viscous.c", "1.0 + law->parameter[1] * rate", "1.0 + 1.1 * law->parameter[1] * rate"),
    ("law/viscous.c", "n * slope * factor", "slope * factor"),
    ("law/viscous.c", "0.25 * damping / d * rate", "0.25 * damping * rate"),
    ("law/viscous.c", "g * sqrt(root)", "g * root"),
    ("law/viscous.c", "root * (d + 1.5 * lag)", "root * (d + lag)"),
    ("law/viscous.c", "root + 0.5 * lag / root", "root"),
    (
        "law/viscous.c",
        "law->parameter[0] * indentation + law",
        "law->parameter[0] * indentation - law",
    ),
    ("law/viscous.c", "      .pulls = 1", "      .pulls = 0"),
    ("law/plastic.c", "p[YIELD] *= p[YIELD]", "p[YIELD] *= 1.0"),
    ("law/plastic.c", "1.5 * p[STIFFNESS] * sqrt(p[YIELD])", "p[STIFFNESS] * sqrt(p[YIELD])"),
    ("law/plastic.c", "* sqrt(deepest)", "* sqrt(law->parameter[YIELD])"),
    ("law/plastic.c", "3.0 * rise - 2.0 * start", "3.0 * rise - start"),
    ("law/plastic.c", "(start + slope - 2.0 * rise)", "(start + slope - rise)"),
    ("law/plastic.c", "x * 3.0 * p[CUBIC]", "x * p[CUBIC]"),
    ("law/plastic.c", "first + second - first * second", "first + second"),
    ("law/plastic.c", "0.5 * slope * p[FULL]", "slope * p[FULL]"),
    (
        "law/plastic.c",
        "past = reach - (memory[DEEPEST] - (indentation > 0.0 ? indentation : 0.0))",
        "past = (indentation > 0.0 ? indentation : 0.0) - (memory[DEEPEST] - reach)",
    ),
    ("law/plastic.c", "1.5 * top * root / reach", "top * root / reach"),
    ("law/plastic.c", "(indentation == end && !rising)", "0"),
    ("law/plastic.c", "(indentation == full && !rising)", "indentation == full"),
    ("law/plastic.c", "&& indentation > memory[DEEPEST]", ""),
    ("law/plastic.c", "0.4 * top_force(law, deepest)", "0.5 * top_force(law, deepest)"),
    (
        "law/laminate.c",
        "deepest - p[BETA] * (deepest - p[CRITICAL])",
        "deepest - p[BETA] * deepest",
    ),
    ("law/laminate.c", "p[CRITICAL] / deepest, 0.4", "p[CRITICAL] / deepest, 0.5"),
    ("law/laminate.c", "1.5 * top * sqrt(share)", "top * sqrt(share)"),
    ("law/laminate.c", "2.5 * value->force", "1.5 * value->force"),
    ("law/laminate.c", "memory[TOP] = yang_sun_rest(law, memory)", "(void)0"),
    ("law/laminate.c", "/ 3.5", "/ 2.5"),
    ("law/table.c", "(d[middle] == indentation && rising)", "0"),
    ("law/table.c", "3.0 * rise - 2.0 * s[i] - s[i + 1]", "3.0 * rise - s[i] - s[i + 1]"),
    ("law/table.c", "x * 3.0 * c.cubic", "x * c.cubic"),
    ("law/table.c", "fmin(fmax(indentation, d[0]), top)", "indentation"),
    ("law/table.c", "fmax(indentation, d[0])", "indentation"),
    ("law/table.c", "+ past * value->stiffness", ""),
    ("law/table.c", "x * (c.square / 3.0 + x * c.cubic / 4.0)", "x * c.square / 2.0"),
    ("law/table.c", "!(table[i] > table[i - 1])", "0"),
    ("law/table.c", "table[count + i] < table[count + i - 1]", "0"),
    ("law/user.c", "LEAST_RATE = 1e-3", "LEAST_RATE = 0.0"),
    ("law/user.c", "INDENTATION_STEP = 1.5e-8", "INDENTATION_STEP = 1e-3"),
    ("law/user.c", "d * s * s, 0.0", "d * s, 0.0"),
    ("law/user.c", "if (!user->given[AOI_USER_FORCE])", "if (0)"),
    ("law/friction.c", "p.slide[0] *= share", "p.slide[0] *= 1.0"),
    ("law/friction.c", "fmin(x * x + y * y - r * r, 0.0)", "0.0"),
    ("law/friction.c", "r + share * r_by, x + share * u", "r, x + share * u"),
    ("law/friction.c", "r + share * r_by, x + share * u", "r + share * r_by, x"),
    ("law/friction.c", "log1p(grown) / grown : 1.0", "1.0 : 1.0"),
    ("law/friction.c", "(1.0 - in.share) / in.radius", "1.0 / in.radius"),
    ("law/friction.c", "(length - in.x) / in.y", "length / in.y"),
    ("law/friction.c", "norm0 / norm * in.share / in.radius", "norm0 / norm / in.radius"),
    ("law/friction.c", "-expm1(-turned) / turned : 1.0", "1.0 : 1.0"),
    ("law/friction.c", "* (1.0 - f0 * f) / norm", "/ norm"),
    ("law/friction.c", "-by_entry * sine0 - sine * rate", "-sine * rate"),
    ("law/friction.c", "k->s_by[i][2] = p->slope * n[i]", "k->s_by[i][2] = 0.0"),
    ("law/friction.c", "s[0] * g[0] + s[1] * g[1] + bound * p->slope", "bound * p->slope"),
    ("law/friction.c", "n[0] * g[0] + n[1] * g[1] + p->slope", "p->slope"),
    ("law/friction.c", "k.s_by[i][j] += g[i] * k.by[j]", "k.s_by[i][j] += 0.0"),
    ("law/friction.c", "if (p->to <= p->from) {", "if (p->to < p->from) {"),
    ("law/friction.c", "if (w->sticks && k->slips) {", "if (0) {"),
    ("law/friction.c", "(at_a->stiffness - mean) * a->by[j]", "0.0 * a->by[j]"),
    ("law/friction.c", "value->stuck = b.depth;", "value->stuck = a.depth;"),
    ("law/friction.c", "MOST_PARTINGS = 6", "MOST_PARTINGS = 1"),
    (
        "law/friction.c",
        "fabs(change) * width > enough * before * after",
        "fabs(change) > enough",
    ),
    ("law/friction.c", "if (count == room) {", "if (count == room + 1) {"),
    ("law/friction.c", "- a.along[j] * at_a - slope * work", "- a.along[j] * at_a"),
    ("law/friction.c", "friction->law.compliance = 0.0;", ""),
    ("law/oblique.c", "!(now.size <= now.enough)", "now.size > now.enough"),
    ("law/oblique.c", "if (next.size < now.size) {", "if (1) {"),
    ("law/oblique.c", "p->slope[i][j] = i == j", "p->slope[i][j] = 1.0"),
    ("law/oblique.c", "share *= 0.5", "share *= 1.0"),
    ("law/oblique.c", "p->by[i][1] * x[1]", "0.0 * x[1]"),
    ("model/coupled.c", "[i + j] - rubbing->compliance[k][j]", "[i + j]"),
    ("model/coupled.c", "size_t j = begin + own, last", "size_t j = i + 1, last"),
    ("model/system.c", "2 * (system->first_force[contact] - contact)", "0"),
    ("model/system.c", "contact->compliance[0] == contact->law->compliance", "1"),
    ("newmark/run.c", "0.5 * (contact[k].force + force[k])", "force[k]"),
    ("newmark/run.c", "[k].from += found->place[k]", "[k].from = found->place[k]"),
    ("newmark/run.c", "+ stretched - taken_out", "+ stretched"),
    (
        "newmark/run.c",
        "equation.compliance[i][j] = -rubbing",
        "equation.compliance[i][j] = 0.0 * rubbing",
    ),
    ("newmark/run.c", "of->work - (stretched - of->start_energy)", "of->work - stretched"),
    ("newmark/run.c", "indentation -= of->compliance[0][k] * force[k]", "indentation -= 0.0"),
    ("law/equation.c", "(next > low && next < high)", "(next >= low && next <= high)"),
    ("law/equation.c", "if (isnan(excess))", "if (!isfinite(excess))"),
    ("law/equation.c", "MOST_ITERATIONS = 2000", "MOST_ITERATIONS = 60"),
    ("law/equation.c", "enough = 4.0 * DBL_EPSILON * x", "enough = 1e-9 * x"),
    ("law/equation.c", "e->compliance * value->damping * e->rate_free", "0.0"),
    ("law/equation.c", "isinf(slope) && excess != 0.0", "0"),
    ("law/equation.c", "!isfinite(equation->rate_free)", "0"),
    ("law/equation.c", "*indentation = s->rest;", "*indentation = e->indentation_free;"),
    ("law/equation.c", "(e->indentation_free - s->rest) / e->compliance", "force_at(s, above)"),
    ("law/equation.c", "(law->depends_on_rate || law->pulls) && ends", "law->pulls && ends"),
    ("law/equation.c", "!(law->pulls && equation->guess > rest)", "1"),
    ("model/coupled.c", "row[band + j];", "row[band + j] * 0.999;"),
    ("model/coupled.c", "x[p] -= row[j] * x[p + j]", "x[p] -= 0.5 * row[j]"),
    ("model/coupled.c", "static const double SHARE = 1e-6", "static const double SHARE = 1e6"),
    ("model/coupled.c", "changed = changed || active[i] != 0.0;", "changed = 0;"),
    ("model/coupled.c", "i - last <= 2 * beyond + e->band", "i - last <= 1"),
    ("model/coupled.c", "own(e, e->rate_compliance, i) * e->force[i]", "0.0 * e->force[i]"),
    ("model/coupled.c", "if (whole > 2.0 &&", "if (0 &&"),
    ("model/coupled.c", "if (!isfinite(e->free[i]) ||", "if (0 * isfinite(e->free[i]) ||"),
    ("motion/lanes.c", "1.0 - 2.0 * sine * sine", "1.0 - sine * sine"),
    ("motion/lanes.c", "odd * value[l][i] - z[i]", "odd * value[l][i] + z[i]"),
    ("motion/lanes.c", "UPWARD_FROM = 6.0", "UPWARD_FROM = 1.0"),
    ("motion/lanes.c", "k * (2.0 - fabs(k))", "k"),
    ("motion/lanes.c", "!(x[i] <= FARTHEST)", "0"),
    ("motion/lanes.c", "LEAST = 1e-36", "LEAST = 1e-160"),
    ("motion/oscillator.c", "NOTHING = 1e-19", "NOTHING = 1e-13"),
    ("motion/oscillator.c", "fabs(before) + fabs(here) > NOTHING", "fabs(here) > 0.0"),
    ("motion/oscillator.c", "term *= -z * z / ((2.0 * k)", "term *= z * z / ((2.0 * k)"),
    ("motion/oscillator.c", "damping * k * here + spring", "damping * here + spring"),
    ("motion/oscillator.c", "exp(-fast * time) - slow", "exp(-slow * time) - slow"),
    ("motion/oscillator.c", "(slow_twice - fast_twice) / apart", "slow_twice / apart"),
    ("motion/oscillator.c", "SLOW_SHARE = 0.5", "SLOW_SHARE = 1e-6"),
    ("motion/oscillator.c", "CRITICAL = 1e-6", "CRITICAL = 1e-2"),
    ("motion/oscillator.c", "rate[k] = real[k] - decay * impulse[k]", "rate[k] = real[k]"),
    (
        "motion/oscillator.c",
        "omega * (omega / (decay + sqrt(fabs(square))))",
        "fmax(0.0, decay - sqrt(fabs(square)))",
    ),
    ("motion/bessel.c", "term > DBL_EPSILON * DBL_EPSILON", "term > 1e-8"),
    ("motion/bessel.c", "k < terms", "k < SERIES_TERMS"),
    ("motion/bessel.c", "here = {1e-60, 0.0}", "here = {1e-250, 0.0}"),
    ("motion/bessel.c", "UPWARD_FROM = 20.0", "UPWARD_FROM = 2.0"),
    ("motion/bessel.c", "MARGIN = 48", "MARGIN = 12"),
    ("motion/bessel.c", "-left * sin(imaginary)", "left * sin(imaginary)"),
    ("model/load.c", "low > 0 ? low - 1 : 0", "low"),
    ("motion/modes.c", "at->here[port] + *slope * at->into", "at->here[port]"),
    ("motion/modes.c", "bend < to ? bend : to", "to"),
    ("motion/modes.c", "slope[i] * by->ramp[i]", "0.0 * by->ramp[i]"),
    ("adaptive/step_end.c", "h + run->left_off, elapsed", "h, elapsed"),
    ("motion/free.c", "velocity += compliance * rise", "velocity -= compliance * rise"),
    ("motion/free.c", "2.0 * decay * pair->v[side][j]", "0.0"),
    ("motion/free.c", "slope - omega * omega * v - 2.0 * decay * a", "slope"),
    ("motion/free.c", "aoi_free_pair_jerk(pair) > 0.0", "0"),
    ("motion/free.c", "? of.bend * within * within : 0.0", "? 0.0 : 0.0"),
    ("motion/free.c", "discriminant < 0.0", "discriminant < 1e-6"),
    ("motion/free.c", "hypot(x - rest, (v - drift) / omega)", "fabs(x - rest)"),
    ("motion/free.c", "made.drift = shape * drift", "made.drift = 0.0"),
    ("motion/free.c", "pair->body[1]->omega[at[1]] <", "pair->body[1]->omega[at[1]] >"),
    ("motion/free.c", "(sum->alike && decay == sum->decay)", "1"),
    ("motion/free.c", "sum->alike ? fmax(sum->now, sum->later)", "0 ? 0.0"),
    ("law/equation.c", "terms > CANCELS * fabs(by_equation)", "0"),
    ("law/table.c", "!energy_is_sound(law, i - 1)", "0"),
    ("linear/krylov.c", "if (aoi_work_stops(space->pause)) {", "if (0) {"),
    ("linear/sparse.c", "taken[place] != 0.0", "0"),
    ("linear/sparse.c", "return aoi_work_stops(factors->pause)", "return 0"),
    ("track/check.c", "return edge == AOI_EDGE_NONE;", "return 1;"),
    ("track/sampler.c", "at[BEND_WORK] += work;", "at[BEND_WORK] = work;"),
    ("track/sampler.c", "if (!(at[BEND_TIME] <= time)) {", "if (isnan(at[BEND_TIME])) {"),
    ("model/system.c", "!body->centre ||", ""),
    ("model/system.c", "first_port[b] + system->body[b].ports", "first_port[b] + 1"),
    ("model/load.c", "load->time[i] >= load->time[i - 1]", "1"),
    ("model/system.c", "contact->body[0] != contact->body[1]", "1"),
    ("model/system.c", "isfinite(contact->gap)", "1"),
    ("model/system.c", "!(values[i] >= 0.0)", "0"),
    ("model/system.c", "!none_negative(body->inertia, n)", "0"),
    ("model/system.c", "fabs(one - other) <= SYMMETRY * most", "1"),
    ("model/system.c", "fabs(one) <= (1.0 + SYMMETRY) * most", "1"),
    ("model/load.c", "!load->time || !load->force", "0"),
    ("model/system.c", "system->first = system->first_port =", "system->first_port ="),
    ("law/law.c", "law && law->force &&", "law->force &&"),
    ("newmark/run.c", "|| rests_deflected(system, start)", ""),
    ("newmark/run.c", "|| !take(start->v, all, run->v)", "|| (take(start->v, all, run->v), 0)"),
    ("newmark/run.c", "last < run->columns ? AOI_OK : AOI_ERROR_ARGUMENT", "AOI_OK"),
    (
        "motion/polynomial.c",
        "slope_before + (4.0 * (double)k + 2.0) * here",
        "(4.0 * (double)k + 2.0) * here",
    ),
    ("motion/polynomial.c", "!found || here > *value", "!found"),
    ("motion/polynomial.c", "i > 1 ? aoi_radau_node[i - 2] : 0.0", "0.0"),
    ("motion/polynomial.c", "|| !(-value < depth)", ""),
    ("motion/response.c", "power[i] *= -square[i]", "power[i] *= square[i]"),
    ("motion/response.c", "m++, scale *= square", "m++"),
    ("motion/response.c", "NOTHING = 1e-18", "NOTHING = 1e-3"),
    ("motion/response.c", "SERIES_LIMIT = 3.0", "SERIES_LIMIT = 12.0"),
    ("motion/response.c", "compliance * slope * h * aoi_radau_node[i]", "compliance * slope * h"),
    ("motion/response.c", "slope, response->ramp + at", "slope, response->step + at"),
    (
        "motion/response.c",
        "influence[k * AOI_NODES + i] = row[k]",
        "influence[i * AOI_NODES + k] = row[k]",
    ),
    ("motion/polynomial.c", "(place * aoi_radau_node[i])", "(aoi_radau_node[i])"),
    ("collocation/many.c", "a == c ? 1.0 : -1.0", "1.0"),
    (
        "collocation/many.c",
        "displacement[k * AOI_NODES + k] += residual",
        "displacement[k] += residual",
    ),
    (
        "collocation/many.c",
        "add_block(entry[s].edge, law->damping,",
        "add_block(entry[s].edge, law->stiffness,",
    ),
    ("collocation/one.c", "+= residual;", "+= 0.0 * residual;"),
    ("collocation/one.c", "add_residual(residual, h, of)", "add_residual(residual, 1.0, of)"),
    ("collocation/one.c", "one[k] + other[k]", "one[k] - other[k]"),
    ("collocation/one.c", "weigh(entry->edge, law->damping", "weigh(entry->edge, law->stiffness"),
    ("motion/nodes.c", "row[k] = factor * pivot_row[k]", "row[k] = factor"),
    ("motion/polynomial.c", "slope[0] += sign *", "slope[0] +="),
    ("collocation/many.c", "h * aoi_radau_extra_weight[i] *", "h *"),
    ("collocation/many.c", "h * aoi_radau_check_weight[k] *", "h *"),
    ("collocation/newton.c", "CONVERGED = 1e-15", "CONVERGED = 1e-5"),
    ("model/system.c", "body->residual || aoi_modes_can_move(body)", "body->push[0] != 0.0"),
    ("model/system.c", "(i / 2 == i % 2 ? 1.0 : -1.0)", "1.0"),
    ("model/system.c", "contact_of[--first_contact", "contact_of[first_contact"),
    (
        "model/system.c",
        "contact->body[side] >= system->body_count",
        "contact->body[side] > system->body_count",
    ),
    ("model/system.c", "system->body[b].n > most", "system->body[b].n < most"),
    ("adaptive/watch.c", "time == its && one < other", "0"),
    ("adaptive/watch.c", "comes_first(run, heap[below + 1], heap[below])", "0"),
    ("adaptive/watch.c", "        rise(run, heap->at, place);\n        sink(", "        sink("),
    (
        "adaptive/watch.c",
        "        sink(run, heap->at, heap->count, run->contact[last].place);\n",
        "",
    ),
    ("adaptive/run.c", "!isfinite(to[j])", "0"),
    ("adaptive/run.c", "    start_ledger(run);\n", ""),
    ("adaptive/run.c", "run->failed = c;\n            return 1;", "return 1;"),
    ("adaptive/step.c", "are_equal(one->push, other->push, one->ports * one->n)", "1"),
    ("adaptive/step.c", "    run->force_scale = force_scale_of(run);\n", ""),
    ("adaptive/step.c", "} else if (massless) {", "} else if (0) {"),
    ("track/intervals.c", "below < 0.0 && below > slope", "0"),
    (
        "adaptive/closing.c",
        "        contact->piece = AOI_SLACK;\n        contact->force = 0.0;\n",
        "",
    ),
    ("adaptive/step.c", "        aoi_step_skip(run, &run->entry[s], attempt);\n", ""),
    ("adaptive/step_events.c", "SKIP_SHARE = 0.1", "SKIP_SHARE = 0.0"),
    ("adaptive/step_events.c", "contact->slack = 0.5 * tolerance", "contact->slack = 0.0"),
    ("adaptive/step_end.c", "largest > law->limit", "0"),
    (
        "adaptive/step_end.c",
        "entry->edge != AOI_EDGE_NONE) {\n        aoi_law_forces",
        "0) {\n        aoi_law_forces",
    ),
    (
        "adaptive/step_error.c",
        "TAIL_SHARE = 0.3, STEP_SHARE = 0.1",
        "TAIL_SHARE = 300.0, STEP_SHARE = 100.0",
    ),
    ("adaptive/step_end.c", "contact->work += aoi_collocation_work(entry)", "contact->work = 0.0"),
    ("adaptive/state.c", "without_forces - aoi_contact_bent(run, c, 0)", "without_forces"),
    (
        "adaptive/step.c",
        "entry->edge = edge_of(run, entry->contact, h)",
        "entry->edge = AOI_EDGE_NONE",
    ),
    (
        "adaptive/step_error.c",
        "slack_growth(run, entry, h, of.within)",
        "BLIND_GROWTH",
    ),
    (
        "adaptive/step_error.c",
        "fmax(rate_tail(entry) - rounding, 0.0) / fmax(slow, DBL_MIN)",
        "0.0",
    ),
    ("adaptive/step_events.c", "        kind = AOI_EVENT_TIGHTEN;\n", ""),
    (
        "adaptive/closing.c",
        "push > 0.0 ? fmin(stop, push) : stop",
        "stop",
    ),
    ("adaptive/step_error.c", "NEAR_TOP = 0.99", "NEAR_TOP = 1.1"),
    ("adaptive/step_error.c", "fabs(value.damping) * rate_tail(entry)", "0.0 * rate_tail(entry)"),
    (
        "adaptive/step_end.c",
        "contact->force = force_at_end(law, entry);",
        "contact->force = entry->force[end];",
    ),
    ("adaptive/step.c", "contact->force == 0.0 ? AOI_EDGE_START", "0 ? AOI_EDGE_START"),
    ("adaptive/step.c", "contact->force == 0.0 ? AOI_EDGE_START", "1 ? AOI_EDGE_START"),
    (
        "adaptive/step_end.c",
        "run->body[b].dissipated += dissipated;\n    }\n}\n\nstatic void move_bodies",
        "}\n}\n\nstatic void move_bodies",
    ),
    ("motion/energy.c", "0.5 * force[k / body->ports]", "force[k / body->ports]"),
    (
        "motion/energy.c",
        "*work += residual_work(body, at, next)",
        "(void)residual_work(body, at, next)",
    ),
    ("motion/energy.c", "- bent_by(", "+ bent_by("),
    ("motion/energy.c", "sum->rising += rise * moment", "sum->rising += 0.5 * rise * moment"),
    ("motion/energy.c", "sum->lost += 2.0 * decay", "sum->lost += decay"),
    ("adaptive/step_end.c", "run->contact[run->entry[s].contact].work += lost;", ""),
    ("adaptive/balance.c", "0.5 * contact->bending", "contact->bending"),
    ("model/system.c", "of->port[i / 2] * body->ports + from->port[i % 2]", "of->port[i / 2]"),
    ("track/sampler.c", "*work += aoi_modes_bent_work(body, time, force);", ""),
    ("track/check.c", "track->rows > 0 && end == track->used ?", "track->rows > 0 ?"),
    ("track/check.c", "(double)*number == value", "1"),
    ("track/check.c", "!(row[AOI_TRACK_LENGTH] > 0.0)", "row[AOI_TRACK_LENGTH] < 0.0"),
    ("track/sampler.c", "        sampler->settled[c] = NAN;\n", ""),
    ("track/sampler.c", "place < 1.0 && of[AOI_TRACK_EDGE] != AOI_EDGE_NONE", "0"),
    (
        "track/sampler.c",
        "aoi_modes_advance(body, start + length, time, state, state + body->n);",
        "",
    ),
    ("newmark/body.c", "h * (0.5 - rule->beta)", "h * rule->beta"),
    ("newmark/body.c", "h * (1.0 - rule->gamma)", "h * rule->gamma"),
    ("newmark/body.c", "rule->beta * h * h", "0.25 * h * h"),
    ("newmark/body.c", "rule->gamma >= 0.5", "rule->gamma >= 0.4"),
    ("newmark/body.c", "free_a[j] + first * gain[j]", "free_a[j] + gain[j]"),
    ("newmark/body.c", "force[p], body->gain + p * n", "0.0, body->gain + p * n"),
    ("newmark/body.c", "0.25 * h * body->kind->power", "0.5 * h * body->kind->power"),
    ("newmark/body.c", "0.5 * force[p] * aoi_stepped_residual", "0.0 * aoi_stepped_residual"),
    ("newmark/modal.c", "step->correct_u + step->correct_v + step->predict_u;", "step->dt;"),
    ("newmark/modal.c", "rate[j] += h * next;", "rate[j] += 0.999 * h * next;"),
    ("newmark/modal.c", "v[j] = w + correct_v * next;", "v[j] = w;"),
    ("newmark/modal.c", "body->free_a[j] - step->predict_v * body->a[j]", "body->free_a[j]"),
    ("newmark/modal.c", "force * body->centre_reached", "0.0"),
    ("newmark/modal.c", "(body->port_a + force * body->reached)", "body->port_a"),
    ("newmark/modal.c", "mobility * modes->gravity[j] : 0.0", "0.0 : 0.0"),
    ("newmark/modal.c", "free_a[j] -= drag[j] * v[j]", "free_a[j] -= 0.5 * drag[j] * v[j]"),
    ("newmark/modal.c", "1.0 + body->step->correct_v * twice_decay(modes, j)", "1.0"),
    ("newmark/modal.c", "= gravity - omega * (", "= -omega * ("),
    ("newmark/run.c", "run->push[p] += run->load[p];", ""),
    ("newmark/run.c", "(run->push_before[p] + slope[p])", "run->push_before[p]"),
    ("newmark/run.c", "settled - aoi_stepped_residual(body, p, before)", "settled"),
    (
        "star/receptance.c",
        "weight[j] / size * (dashpot / size)",
        "weight[j] / size * (spring / size)",
    ),
    ("newmark/full.c", "1.0, body->model->gravity, out", "0.0, body->model->gravity, out"),
    (
        "newmark/full.c",
        "aoi_vector_add(n, -alpha, product, out)",
        "aoi_vector_add(n, alpha, product, out)",
    ),
    ("newmark/full.c", "spare[i] = u[i] + beta * v[i]", "spare[i] = u[i]"),
    (
        "newmark/full.c",
        "0.5 * aoi_sparse_quadratic(&model->full->K, body->x)",
        "aoi_sparse_quadratic(&model->full->K, body->x)",
    ),
    ("newmark/full.c", "== 0 ? AOI_OK : AOI_ERROR_SOLVER", "== 0 ? AOI_OK : AOI_OK"),
    ("model/load.c", "load->time[middle] <= time", "load->time[middle] < time"),
    ("model/load.c", "(low > 0 ? low - 1 : 0) * ports", "(low > 0 ? low - 1 : 0)"),
    ("newmark/run.c", "(at.into / at.length)", "at.into"),
    (
        "newmark/run.c",
        "push[run->state[c].port[0]] -= force[c]",
        "push[run->state[c].port[0]] += force[c]",
    ),
    (
        "newmark/run.c",
        "run->velocity[port[0]] - run->velocity[port[1]]",
        "run->velocity[port[0]] + run->velocity[port[1]]",
    ),
    ("newmark/run.c", "- run->system->contact[c].gap", ""),
    ("newmark/run.c", "run->done = column - 1", "run->done = column"),
    ("newmark/run.c", "far == side ? share : -share", "share"),
    ("newmark/run.c", "0.5 * (run->load_before[p] + run->load[p])", "run->load[p]"),
    ("newmark/run.c", "- run->gravity_start[b]", "+ run->gravity_start[b]"),
    ("newmark/run.c", "energies ? all : 2", "energies ? all : all"),
    ("newmark/run.c", "contact->force + e->force[c]", "2.0 * contact->force"),
    (
        "newmark/run.c",
        "press(run, b, p, run->load[first[b] + p]);",
        "press(run, b, p, run->load_before[first[b] + p]);",
    ),
    ("newmark/run.c", "memcpy(run->push, run->load, bytes);", "memset(run->push, 0, bytes);"),
    ("track/intervals.c", "open->lasts = 1;", ""),
    (
        "adaptive/closing.c",
        "contact->start_rate = contact->touch_rate = rate",
        "contact->start_rate = rate",
    ),
    ("track/intervals.c", "open->end = end;", "open->end = open->start;"),
    ("track/brief.c", "interval[0].start", "interval[count - 1].start"),
    ("track/brief.c", "brief->touches > 0 ? brief->end", "0 ? brief->end"),
    ("model/system.c", "AOI_PORT_ROWS * system->first_port[body]", "0"),
    ("adaptive/run.c", "run->time < run->end ? AOI_ERROR_TOO_LONG", "0 ? AOI_ERROR_TOO_LONG"),
    ("adaptive/balance.c", "SUDDEN = 1e-22", "SUDDEN = 1e-4"),
    ("adaptive/step_open.c", "x[j] -= here;", ""),
    ("adaptive/step_open.c", "rate * response->impulse[at + i]", "0.0 * response->impulse[at + i]"),
    ("adaptive/step_open.c", "here * (1.0 - squared * response->step[at + i])", "here"),
    ("adaptive/step_open.c", "{-aoi_contact_bent(run, c, 0)}", "{0.0}"),
    (
        "adaptive/step_open.c",
        "aoi_nodes_add(sign * body->residual[port * body->ports + by], force, indentation);",
        "(void)force;",
    ),
    ("adaptive/step_open.c", "run->body[b].engaged == AOI_UNDER_FORCE", "0"),
    ("adaptive/step_open.c", "pair.gap += rest + slack", "pair.gap += rest + 1e6 * slack"),
    ("motion/path.c", "f[k] - 2.0 * decay * slope - bend", "f[k] - 2.0 * decay * slope"),
    ("motion/path.c", "f[k] - 2.0 * decay * slope - bend", "f[k] - bend"),
    ("motion/path.c", "*x -= aoi_legendre_evaluate", "(void)aoi_legendre_evaluate"),
    ("motion/path.c", "*v -= aoi_legendre_evaluate", "(void)aoi_legendre_evaluate"),
    ("motion/path.c", "sign = -sign", "sign = sign"),
    ("motion/path.c", "*squared += 2.0 * of *", "*squared += of *"),
    ("motion/path.c", "k < 2 ? 0.5 * time * of : 0.0", "k < 1 ? 0.5 * time * of : 0.0"),
    ("motion/path.c", "0.25 * lost / path->decay", "0.5 * lost / path->decay"),
    ("motion/path.c", "v * v - later * later + pull * x - apart * apart", "v * v - later * later"),
    ("adaptive/balance.c", "PART_RELAXED = 1e-5", "PART_RELAXED = 1e-2"),
    ("adaptive/run.c", "            note_starts(run);\n", ""),
    ("track/sampler.c", ": of[AOI_TRACK_START_FORCE]", ": 0.0"),
    ("model/coupled.c", "YIELD = 1.0 - 1e-6", "YIELD = 1.0"),
    ("adaptive/balance.c", "RIGID = 1e15", "RIGID = 1e20"),
    ("adaptive/balance.c", "rate + (here - contact->indentation) / time", "rate"),
    ("adaptive/balance.c", "indentation -= (side == 0", "indentation += 0.0 * (side == 0"),
    ("adaptive/balance.c", "run->rested ? 0.0 : SUDDEN", "1 ? 0.0 : SUDDEN"),
    ("adaptive/run.c", "!aoi_vector_is_finite(size, row)", "0"),
    ("adaptive/balance.c", "bending = e->force[i];", "force = 0.0;"),
    ("adaptive/balance.c", "contact->event != AOI_EVENT_TOUCH &&", ""),
    ("adaptive/balance.c", "            aoi_contact_close(run, c);\n", ""),
    ("adaptive/run.c", "        forget_events(run);\n", ""),
    ("adaptive/step.c", "entry->constant = contact->bending;", "entry->constant = 0.0;"),
    ("model/coupled.c", "has_failed(status) && end_next(s)", "0"),
    ("adaptive/step_open.c", "aoi_is_at_start(run, after, attempt->h) ||", ""),
    ("motion/free.c", "indentation > -rounding && !closes", "!closes"),
    ("motion/free.c", "pair->forced ? 0.5 * pair->forced->bend : 0.0", "0.0"),
    (
        "motion/free.c",
        "forced->bend += fabs(forced->series[2][k])",
        "forced->bend += forced->series[2][k]",
    ),
    ("motion/free.c", "*rate = forced_at(pair, 1)", "*rate = 0.0"),
    ("adaptive/closing.c", "value.force) - force * (next - here)", "value.force)"),
    ("adaptive/closing.c", "here -= aoi_contact_bent(run, c, 0);", ""),
    ("adaptive/closing.c", "    run->unbalanced = 1;\n", ""),
    ("adaptive/step_end.c", "law->limit < HUGE_VAL &&", "0 &&"),
    (
        "motion/energy.c",
        "2.0 * decay * aoi_modes_inertia(body, j) * squared",
        "decay * aoi_modes_inertia(body, j) * squared",
    ),
    ("motion/energy.c", "force[1] = 0.5 * slope * length", "force[1] = 0.0"),
    ("motion/path.c", "aoi_path_rings(path->omega, decay, path->h)", "path->omega * path->h > 6.0"),
    ("motion/free.c", "pair->gap += indentation + rounding;", ""),
    ("motion/free.c", "!closes(pair, rate, acceleration)", "rate < 0.0"),
    ("motion/free.c", "jerk = forced_at(pair, 3)", "jerk = 0.0"),
    ("motion/free.c", "*acceleration = forced_at(pair, 2)", "*acceleration = 0.0"),
    ("motion/free.c", "2.0 * fabs(acceleration) * rounding", "0.0"),
    ("motion/free.c", "jerk > 0.0 ? fmin", "0 ? fmin"),
    ("adaptive/closing.c", "(power + 1.0)", "(power + 2.0)"),
    ("adaptive/closing.c", "fmin(here * exp(STRIDE), most)", "here * exp(STRIDE)"),
    ("adaptive/closing.c", "return shallow(law, memory, energy, force, here);", "return here;"),
    (
        "adaptive/closing.c",
        "left * (rate + 0.5 * acceleration * left))",
        "HUGE_VAL)",
    ),
    ("adaptive/closing.c", "0.5 * acceleration * left * left", "HUGE_VAL"),
    ("motion/path.c", "path->decay * time > STRONG", "0"),
    ("motion/path.c", "work += weight * v *", "work += 0.5 * weight * v *"),
    ("adaptive/closing.c", "next, value.force) - force * (next - here);", "next, value.force);"),
    ("motion/path.c", "f[m] - lag * next - inverse * after", "f[m] - inverse * after"),
    ("motion/path.c", "f[m] - lag * next - inverse * after", "f[m] - lag * next"),
    ("motion/path.c", "*v = after /", "*v = 0.0 * after /"),
    ("motion/polynomial.c", "(bend[i] > 0.0) == falls", "0"),
    ("adaptive/step_ring.c", "UNRESOLVED = 12.0", "UNRESOLVED = 1e9"),
    ("adaptive/step_ring.c", "!(sum <= 0.5 * most)", "!(sum <= 50.0 * most)"),
    ("adaptive/closing.c", "now.acceleration -= sign * shape *", "now.acceleration -= 0.0 *"),
    ("adaptive/closing.c", "now.acceleration < 0.0 && slow.amplitude_rate > slow.rate", "0"),
    ("motion/even.c", "even->left > 0 && ", ""),
    ("motion/even.c", "even->time >= from && ", "even->time >= 0.0 && "),
    ("motion/even.c", "even->fastest <= SMALL_ANGLE", "0.0 <= SMALL_ANGLE"),
    ("motion/even.c", "spacing - even->spacing, even->x[i]", "0.0, even->x[i]"),
    ("motion/even.c", "of->damping[i] * rate", "0.0"),
    ("motion/even.c", "- of->spring[i] * to", "- of->spring[i] * x[i]"),
    (
        "track/sampler.c",
        "!body->decay && !body->gravity && body->load.count == 0",
        "!body->gravity && body->load.count == 0",
    ),
    ("motion/energy.c", "body->inertia ? AOI_LANES : 0", "0"),
]


def compile_file(
    compiler: str, source: Path, core: Path, compiled: Path, more: Sequence[str] = ()
) -> None:
    compiled.parent.mkdir(exist_ok=True)
    flags = ["-std=c99", "-O1", "-w", f"-I{PUBLIC}", f"-I{core}", f"-I{HERE}", *more]
    command = [compiler, *flags, "-c", source, "-o", compiled]
    subprocess.run(command, check=True)


def compiled(source: Path, out: Path) -> Path:
    return out / source.parent.name / f"{source.stem}.o"


def includes(source: Path, header: str) -> bool:
    return f'#include "{header}"' in source.read_text()


def passes(compiler: str, test: str, out: Path) -> bool:
    """True if a test program, linked with the core as it is now, passes."""
    objects = out.glob("*/*.o")
    program = out / test
    command = [compiler, out / f"{test}.o", *sorted(objects), "-lm", "-o", program]
    subprocess.run(command, check=True)
    limited = ["prlimit", f"--cpu={LONGEST}", program]
    return subprocess.run(limited, capture_output=True).returncode == 0


def noticed_by(compiler: str, tests: list[str], first: list[str], out: Path) -> str | None:
    """Return the test program that fails; those of `first` are tried before the others."""
    rest = [test for test in tests if test not in first]
    in_turn = [test for test in dict.fromkeys(first) if test in tests] + rest
    return next((test for test in in_turn if not passes(compiler, test, out)), None)


def main() -> int:
    compiler = sys.argv[1] if len(sys.argv) > 1 else "cc"
    tests = sorted(path.stem for path in HERE.glob("test_*.c"))
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        core, out = Path(folder, "csrc"), Path(folder, "build")
        shutil.copytree(CORE, core)
        out.mkdir()
        sources = [path for path in core.glob("*/*.c") if path.parent.name != "python"]
        for source in sources:
            compile_file(compiler, source, core, compiled(source, out))
        for test in tests:
            compile_file(compiler, HERE / f"{test}.c", core, out / f"{test}.o")
        if noticed_by(compiler, tests, [], out):
            print("the tests fail as it is")
            return 1
        last: dict[str, str] = {}  # the program that noticed the file's last mutant
        for name, old, new in MUTANTS:
            text = (CORE / name).read_text()
            if old not in text:
                print(f"{name}: '{old}' is not there any more")
                failed += 1
                continue
            (core / name).write_text(text.replace(old, new))
            changed = [path for path in sources if path == core / name or includes(path, name)]
            for path in changed:
                compile_file(compiler, path, core, compiled(path, out))
            own = [f"test_{part}" for part in (Path(name).stem, Path(name).parent.name)]
            found = noticed_by(compiler, tests, [last.get(name, own[0]), *own], out)
            if found:
                last[name] = found
            else:
                print(f"{name}: no test notices '{new}' for '{old}'")
                failed += 1
            (core / name).write_text(text)
            for path in changed:
                compile_file(compiler, path, core, compiled(path, out))
    print(f"mutants: {len(MUTANTS) - failed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
