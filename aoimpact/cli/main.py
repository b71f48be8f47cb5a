"""The command line: ``python -m aoimpact <command>``."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Sequence
from typing import Any

from .. import __version__
from ..base import AOImpactError, InputError

_FOLDER = "folder for {}, made if there is none (default: {})"
_NOTHING = "nothing is written"

Command = Callable[[argparse.Namespace], None]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0, 2 for a wrong input, 1 for a computation that failed."""
    parser = _parser()
    options = parser.parse_args(arguments)
    command: Command = options.command
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal may have no "µ"
    try:
        command(options)
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
    for add in (_add_paper, _add_run, _add_compare):
        add(commands)
    return parser


def _add_paper(commands: Any) -> None:
    parser = commands.add_parser(
        "paper",
        help="recompute the paper's tables and figures beside its numbers",
        description=(
            "Recompute every table and Figures 3 to 11 of E. Jacquelin, 'On the rigid projectile "
            "model for low velocity impacts', beside the numbers that the paper prints: what "
            "agrees, what does not, and why. Takes about a minute."
        ),
    )
    files = "the figures (PNG) and for results.csv and results.md"
    parser.add_argument(
        "--out", metavar="DIR", default="paper-results", help=_FOLDER.format(files, "%(default)s")
    )
    parser.set_defaults(command=_paper)


def _paper(options: argparse.Namespace) -> None:
    from ..paper import reproduce

    done = reproduce(options.out)
    print(done)
    print(f"\n{len(done.files)} files in {done.files[0].parent}:")
    print("  " + ", ".join(file.name for file in done.files))


def _add_run(commands: Any) -> None:
    parser = commands.add_parser(
        "run",
        help="run a scene file",
        description=(
            "Run the impact that a TOML file describes (see docs/scene-files.md) and print what "
            "comes of it: peak force, contact time, rebound, and how wrong they may be. A file "
            "with a [sweep] is run once for each combination of its values, and a table is printed."
        ),
    )
    parser.add_argument("scene", metavar="SCENE.toml", help="the scene file")
    files = "histories (CSV), figures (PNG) and fields of meshed bodies (VTU), or a sweep's table "
    parser.add_argument("--out", metavar="DIR", help=_FOLDER.format(files + "and figure", _NOTHING))
    parser.add_argument("--json", action="store_true", help="print JSON, for machines")
    parser.add_argument(
        "--workers", type=int, metavar="N", help="threads of a sweep (default: as in the file)"
    )
    parser.add_argument(
        "--checkpoint",
        metavar="FILE",
        help="keep a sweep's finished cases in a file, from which the same call goes on",
    )
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from ..base import held_warnings
    from ..batch import sweep_file
    from ..scenefile import read_scene
    from .files import as_json, numbers, rows, write_files, write_sweep

    scene = read_scene(options.scene)
    if not scene.grid and (options.workers is not None or options.checkpoint):
        raise InputError(
            f"{scene.path}: --workers and --checkpoint need a [sweep], which this file lacks"
        )
    result: Any
    with held_warnings() as warnings:
        if scene.grid:
            result = sweep_file(scene, workers=options.workers, checkpoint=options.checkpoint)
            files = write_sweep(result, options.out) if options.out else ()
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


def _add_compare(commands: Any) -> None:
    parser = commands.add_parser(
        "compare",
        help="compare models of a scene file's impact, from rigid to full",
        description=(
            "Run the impact that a TOML file describes with rigid bodies, with more and more "
            "anti-oscillators, with natural modes and in full, and print what each costs and how "
            "wrong it is."
        ),
    )
    parser.add_argument("scene", metavar="SCENE.toml", help="the scene file")
    files = "the table (CSV) and figure (PNG)"
    parser.add_argument("--out", metavar="DIR", help=_FOLDER.format(files, _NOTHING))
    parser.add_argument(
        "--no-full",
        action="store_true",
        help="leave out the full model; errors are then relative to the most anti-oscillators",
    )
    parser.set_defaults(command=_compare)


def _compare(options: argparse.Namespace) -> None:
    from pathlib import Path

    from ..scenefile import read_scene
    from ..study import compare

    scene = read_scene(options.scene)
    if scene.kind != "impact":
        raise InputError(f"{scene.path}: compare needs an [impact] of two bodies, not a [scene]")
    case = scene.case()
    for name in ("solver", "quantity", "rtol"):  # every model is run by what suits it, in full
        case.pop(name, None)
    table = compare(**case, full=not options.no_full)
    print(f"{scene.title}\n{table}")
    if options.out:
        folder = Path(options.out)
        folder.mkdir(parents=True, exist_ok=True)
        table.to_csv(folder / "comparison.csv")
        axes: Any = table.plot()
        axes.figure.savefig(folder / "comparison.png")
        print(f"comparison.csv, comparison.png in {folder}")
