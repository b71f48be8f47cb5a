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
from pathlib import Path

HERE = Path(__file__).resolve().parent
CORE = HERE.parents[1] / "csrc"

MUTANTS = [
    ("vector.c", "i + 4 <= n; i += 4", "i + 4 < n; i += 5"),
    ("vector.c", "y[i] += factor * x[i]", "y[i] -= factor * x[i]"),
    ("sparse.c", "if (p < end) {", "if (p + 1 < end) {"),
    ("sparse.c", "< 0 || (size_t)matrix->indices[p] >=", "< 0 || (size_t)matrix->indices[p] >"),
    ("sparse.c", "rows[p] <= (int32_t)j", "rows[p] < (int32_t)j"),
    ("sparse.c", "!(factors->pivots[j] > 0.0)", "!(factors->pivots[j] >= 0.0)"),
    ("sparse.c", "x[j + c] / factors->pivots[j + c]", "x[j + c]"),
    ("sparse.c", "permuted[factors->place[i]] = x[i]", "permuted[i] = x[factors->place[i]]"),
    ("sparse.c", "(v2[i] * y[2] + v3[i] * y[3])", "(v2[i] * y[2] - v3[i] * y[3])"),
    ("sparse.c", "v0[i] * y[0] + v1[i] * y[1] + v2[i] * y[2];", "v0[i] * y[0] + v1[i] * y[1];"),
    ("reduce.c", "*stiffness = 1.0 / compliance", "*stiffness = compliance"),
    ("reduce.c", "phi_st[i] /= reach", "phi_st[i] /= sqrt(reach)"),
    ("reduce.c", "*mass = 1.0 / reach", "*mass = reach"),
    ("reduce.c", "reach > 1e4 * DBL_EPSILON", "reach > 1e-9 * DBL_EPSILON"),
    ("reduce.c", "pass < 2", "pass < 1"),
    ("reduce.c", "b[0] < 0.0 ? -1.0 : 1.0", "b[0] < 0.0 ? 1.0 : -1.0"),
    ("reduce.c", "sqrt(aoi_vector_dot(n, h, h) / 2.0)", "sqrt(aoi_vector_dot(n, h, h))"),
    ("reduce.c", "-0.5 * aoi_vector_dot(n, h, work)", "0.5 * aoi_vector_dot(n, h, work)"),
    ("reduce.c", "mass[j] = coupling * coefficient[j]", "mass[j] = coupling * coupling"),
    ("reduce.c", "stiffness[j] = omega2[j] * mass[j]", "stiffness[j] = sqrt(omega2[j]) * mass[j]"),
    ("secular.c", "moved <= 2.0 * DBL_EPSILON * fabs(x)", "moved <= 1e-13 * fabs(x)"),
    ("secular.c", "*slope = s->linear + sum + x * sum_of_squares", "*slope = s->linear"),
    ("secular.c", "(s->pole[j] - origin) - offset", "s->pole[j] - (origin + offset)"),
    ("secular.c", "gap == last || value >= 0.0", "gap == last || value < 0.0"),
    ("secular.c", "if (!(right > left))", "if (right < left)"),
    ("star.c", "1.0 / (star->k0 - x * inertia)", "1.0 / (star->k0 + x * inertia)"),
    ("star.c", "return star->m0 + sum", "return sum"),
    ("star.c", "u[i + 1] - u[0]", "u[i + 1] + u[0]"),
    ("star.c", "star->k0 * u[0] * u[0]", "0.0 * u[0]"),
    ("star.c", "mass += star->m[i] * gain * gain", "mass += star->m[i] * gain"),
    ("star.c", "*m0 = 1.0 / inverse_mass", "*m0 = inverse_mass"),
    ("star.c", "1.0 / (antiresonance * slope)", "1.0 / slope"),
    ("star.c", "star->m[i] <= 0.0 ||", "star->m[i] < 0.0 ||"),
    ("star.c", "weight[j] <= 0.0", "weight[j] < 0.0"),
    ("law.c", "1.5 * law->parameter[0] * root", "1.4 * law->parameter[0] * root"),
    ("law.c", "0.4 * law->parameter[0] * d * d", "0.5 * law->parameter[0] * d * d"),
    ("law.c", "/ (n + 1.0)", "/ n"),
    ("law.c", "law->parameter[1] * slope", "slope"),
    ("law.c", "0.5 * law->parameter[0] * indentation", "law->parameter[0] * indentation"),
    ("law.c", "parameter[j] < laws[i].least[j]", "0"),
    ("contact.c", "next > low && next < high", "next >= low && next <= high"),
    ("contact.c", "isnan(excess)", "!isfinite(excess)"),
    ("contact.c", "MOST_ITERATIONS = 2000", "MOST_ITERATIONS = 60"),
    ("contact.c", "moved <= 4.0 * DBL_EPSILON * x", "moved <= 1e-9 * x"),
    ("contact.c", "!isfinite(equation->rate_free)", "0"),
    ("newmark.c", "h * (0.5 - rule->beta)", "h * rule->beta"),
    ("newmark.c", "h * (1.0 - rule->gamma)", "h * rule->gamma"),
    ("newmark.c", "rule->beta * h * h", "0.25 * h * h"),
    ("newmark.c", "sum[0] += reaction[i] * q", "sum[0] += 0.99 * reaction[i] * q"),
    ("newmark.c", "push - star->k0 * u[0]", "push"),
    ("newmark.c", "gain[i] * (rise - s[i])", "gain[i] * (rise + s[i])"),
    ("newmark.c", "c[CORRECT_U] * (own - lead)", "c[CORRECT_U] * own"),
    ("newmark.c", "star->m[i] + reach * star->k[i]", "star->m[i] + 0.999999 * reach * star->k[i]"),
    ("newmark.c", "star->m0 > 0.0 ? c[CORRECT_V] : reach / h", "c[CORRECT_V]"),
    ("newmark.c", "u_out[i] = u[0] + u[i]", "u_out[i] = u[i]"),
    ("newmark.c", "double centre = all * u[0] +", "double centre = u[0] +"),
    ("newmark.c", "rule->gamma >= 0.5", "rule->gamma >= 0.4"),
    ("newmark.c", "const double speed = v[0] + v[i + 1]", "const double speed = v[i + 1]"),
    ("newmark.c", "* u[i] - a[0];", "* u[i];"),
    ("full.c", "free_a[i] = -free_a[i]", "free_a[i] = 1.0 * free_a[i]"),
    ("full.c", "free_a[i] + force * unit_a[i]", "free_a[i] + unit_a[i]"),
    ("full.c", "0.5 * aoi_sparse_quadratic(&full->K, u)", "aoi_sparse_quadratic(&full->K, u)"),
    ("full.c", "c[REACH] = rule->beta * h * h", "c[REACH] = h * h / 4.0"),
    ("full.c", "rule->gamma >= 0.5", "rule->gamma >= 0.3"),
    ("full.c", "return AOI_ERROR_SOLVER", "return AOI_OK"),
    (
        "impact.c",
        "projectile->correct(projectile, -*force)",
        "projectile->correct(projectile, *force)",
    ),
    ("impact.c", "v_projectile - v_target,", "v_projectile + v_target,"),
    ("impact.c", "u_projectile - u_target - impact->gap", "u_projectile - u_target"),
    ("impact.c", "*done = column - 1", "*done = column"),
    ("impact.c", "projectile->compliance + target->compliance,", "projectile->compliance,"),
    ("impact.c", "impact->gap >= 0.0", "impact->gap > -1.0"),
    ("impact.c", "if (!(compliance > 0.0))", "if (compliance < 0.0)"),
]


def compile_file(compiler: str, source: Path, core: Path, out: Path) -> None:
    flags = ["-std=c99", "-O1", "-w", f"-I{core}", f"-I{HERE}"]
    command = [compiler, *flags, "-c", source, "-o", out / f"{source.stem}.o"]
    subprocess.run(command, check=True)


def passes(compiler: str, test: str, out: Path) -> bool:
    """Whether a test program, linked with the core as it is now, passes."""
    objects = [path for path in out.glob("*.o") if not path.stem.startswith("test_")]
    program = out / test
    command = [compiler, out / f"{test}.o", *sorted(objects), "-lm", "-o", program]
    subprocess.run(command, check=True)
    try:
        return subprocess.run([program], capture_output=True, timeout=60).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def survives(compiler: str, tests: list[str], own: str, out: Path) -> bool:
    """Whether every test program passes; the file's own is asked first."""
    in_turn = sorted(tests, key=lambda test: test != f"test_{own}")
    return all(passes(compiler, test, out) for test in in_turn)


def main() -> int:
    compiler = sys.argv[1] if len(sys.argv) > 1 else "cc"
    tests = sorted(path.stem for path in HERE.glob("test_*.c"))
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        core, out = Path(folder, "csrc"), Path(folder, "build")
        shutil.copytree(CORE, core)
        out.mkdir()
        for source in [p for p in core.glob("*.c") if p.name != "python.c"]:
            compile_file(compiler, source, core, out)
        for test in tests:
            compile_file(compiler, HERE / f"{test}.c", core, out)
        if not survives(compiler, tests, "", out):
            print("the tests fail as it is")
            return 1
        for name, old, new in MUTANTS:
            text = (CORE / name).read_text()
            if old not in text:
                print(f"{name}: '{old}' is not there any more")
                failed += 1
                continue
            compiled = (out / name).with_suffix(".o")
            sound = compiled.read_bytes()
            (core / name).write_text(text.replace(old, new))
            compile_file(compiler, core / name, core, out)
            if survives(compiler, tests, Path(name).stem, out):
                print(f"{name}: no test notices '{new}' for '{old}'")
                failed += 1
            compiled.write_bytes(sound)
    print(f"mutants: {len(MUTANTS) - failed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
