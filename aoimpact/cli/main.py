"""The command line: ``python -m aoimpact <command>``."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from .. import __version__
from ..base import AOImpactError, InputError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit code: 2 after wrong input, 1 after a failure, else 0."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal may have no "µ"
    try:
        options.command(options)
    except InputError as error:
        print(f"{parser.prog}: error: {error}", file=sys.stderr)
        return 2
    except (AOImpactError, OSError, MemoryError) as error:
        print(f"{parser.prog}: failed: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"{parser.prog}: interrupted", file=sys.stderr)
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="aoimpact",
        description="Low-velocity impact on structures by anti-oscillator models.",
        epilog="aoimpact <command> --help describes each command.",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="<command>", required=True)

    def add(
        command: Callable[..., None], summary: str, out: str, **more: Any
    ) -> argparse.ArgumentParser:
        name = command.__name__.strip("_")
        added = commands.add_parser(name, help=summary, description=command.__doc__)
        if name != "paper":
            added.add_argument("scene", metavar="SCENE.toml", help="the scene file")
        nothing = "%(default)s" if more else "nothing is written"
        text = f"folder for {out}, made if there is none (default: {nothing})"
        added.add_argument("--out", metavar="DIR", help=text, **more)
        added.set_defaults(command=command)
        return added

    files = "the figures (PNG) and for results.csv and results.md"
    add(_paper, "recompute the paper's tables and figures", files, default="paper-results")
    files = "histories (CSV), figures (PNG), fields of bodies (VTU), or the table of a sweep"
    run = add(_run, "run a scene file", files)
    run.add_argument("--json", action="store_true", help="print JSON, for machines")
    workers = "threads of a sweep (default: as in the file)"
    run.add_argument("--workers", type=int, metavar="N", help=workers)
    resumed = "keep a sweep's finished cases in a file, from which the same call goes on"
    run.add_argument("--checkpoint", metavar="FILE", help=resumed)
    compared = "compare models of a scene file's impact, from rigid to full"
    compare = add(_compare, compared, "the table (CSV) and figure (PNG)")
    least = "leave out the full model; errors are then relative to the most anti-oscillators"
    compare.add_argument("--no-full", action="store_true", help=least)
    return parser


def _paper(options: argparse.Namespace) -> None:
    """Recompute the paper's tables and Figures 3 to 11, in about a minute.

    E. Jacquelin, 'On the rigid projectile model for low velocity impacts'. Each number is shown
    beside the one that the paper prints, with the reason of any difference.
    """
    from ..paper import reproduce

    files = reproduce(options.out)
    print(files[1].read_text(encoding="utf-8"))
    print(f"{len(files)} files in {files[0].parent}:")
    print("  " + ", ".join(file.name for file in files))


def _run(options: argparse.Namespace) -> None:
    """Run the impact or scene of a TOML file, see docs/scene-files.md, and print a summary.

    The summary has the peak force, the contact time, the rebound, and their estimated errors. A
    file with a [sweep] is run once for each combination of its values, and a table is printed.
    """
    from ..base import held_warnings, writable_folder
    from ..batch import sweep_file
    from ..scenefile import read_scene
    from .files import as_json, numbers, rows, write_files

    scene = read_scene(options.scene)
    if not scene.grid and (options.workers is not None or options.checkpoint):
        raise InputError(
            f"{scene.path}: --workers and --checkpoint need a [sweep], which this file lacks"
        )
    result: Any
    files: tuple[Path, ...] = ()
    with held_warnings() as warnings:
        if scene.grid:
            result = sweep_file(scene, workers=options.workers, checkpoint=options.checkpoint)
            if options.out:
                files = (writable_folder(options.out) / "sweep.csv",)
                result.to_csv(files[0])
        else:
            result = scene.simulate()
            files = write_files(scene, result, options.out) if options.out else ()
    for warning in warnings:
        print(f"aoimpact: warning: {warning}", file=sys.stderr)
    if options.json:
        report: dict[str, Any] = {"scene": str(scene.path), "title": scene.title}
        report |= rows(result) if scene.grid else numbers(result, scene.reported)
        report |= {"warnings": warnings, "files": [str(file) for file in files]}
        print(as_json(report))
        return
    print(f"{scene.title}\n{result}")
    if files:
        print(f"{', '.join(file.name for file in files)} in {files[0].parent}")


def _compare(options: argparse.Namespace) -> None:
    """Run the impact of a TOML file with models from rigid bodies to the full ones.

    The models in between have increasing numbers of anti-oscillators or natural modes. The cost and
    the errors of each model are printed.
    """
    from ..base import writable_folder
    from ..scenefile import read_scene
    from ..study import compare

    scene = read_scene(options.scene)
    if scene.kind != "impact":
        raise InputError(f"{scene.path}: compare needs an [impact] of two bodies, not a [scene]")
    case = scene.case()
    for name in ("solver", "quantity", "rtol"):  # compare sets these for each model itself
        case.pop(name, None)
    table = compare(**case, full=not options.no_full)
    print(f"{scene.title}\n{table}")
    if options.out:
        folder = writable_folder(options.out)
        table.to_csv(folder / "comparison.csv")
        axes: Any = table.plot()
        axes.figure.savefig(folder / "comparison.png")
        print(f"comparison.csv, comparison.png in {folder}")
