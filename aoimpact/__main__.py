"""The command line: ``python -m aoimpact <command>``."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Sequence

from . import __version__
from .errors import AOImpactError, InputError

Command = Callable[[argparse.Namespace], None]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0, 2 for a wrong input, 1 for a computation that failed."""
    parser = _parser()
    options = parser.parse_args(arguments)
    command: Command = options.command
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
        epilog="aoimpact <command> --help says more about each command.",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="<command>", required=True)
    _add_paper(commands)
    _add_study(commands)
    return parser


def _add_paper(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "paper",
        help="recompute the paper's tables and figures beside its numbers",
        description=(
            "Recompute every table and Figures 3 to 11 of E. Jacquelin, 'On the rigid projectile "
            "model for low velocity impacts', beside the numbers that the paper prints: what "
            "agrees, what does not, and why. Takes about a minute."
        ),
    )
    command.add_argument(
        "--out",
        metavar="DIR",
        default="paper-results",
        help="folder for the figures (PNG) and for results.csv and results.md, made if there is "
        "none (default: %(default)s)",
    )
    command.set_defaults(command=_paper)


def _paper(options: argparse.Namespace) -> None:
    from .paper import reproduce

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal may have no "µ"
    done = reproduce(options.out)
    print(done)
    print(f"\n{len(done.files)} files in {done.files[0].parent}:")
    print("  " + ", ".join(file.name for file in done.files))


def _add_study(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "study",
        help="measure speed against error, beside other methods",
        description=(
            "Measure what Adaptive and Newmark need for what they get right, and SciPy's solvers "
            "on request, on two impacts: two spheres of one anti-oscillator each, and a rigid "
            "sphere on a beam of 28 over 20 ms. Takes some seconds, with SciPy a minute or two."
        ),
    )
    command.add_argument("--scene", choices=("pair", "beam"), help="one of them (default: both)")
    command.add_argument(
        "--out",
        metavar="DIR",
        default="study-results",
        help="folder for tables (CSV) and figures (PNG), made if there is none (default: "
        "%(default)s)",
    )
    command.add_argument("--scipy", action="store_true", help="measure SciPy's solvers as well")
    command.set_defaults(command=_study)


def _study(options: argparse.Namespace) -> None:
    from .study_scenes import SCENES, report

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal may have no "µ"
    for scene in (options.scene,) if options.scene else SCENES:
        study, files = report(scene, options.out, scipy=options.scipy)
        print(study)
        print(f"{', '.join(file.name for file in files)} in {files[0].parent}\n")


if __name__ == "__main__":
    sys.exit(main())
