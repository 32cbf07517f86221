"""``python -m e2e.delay``: chapter 5 again, over shaped networks; figures, and a page of them.

Exit status: 0 when all was measured, or could not be on this machine, which the page tells; 1 when
a goal is missed; 2 when a cell failed or what was asked for is not there; 77 when this machine has
not what the lab needs (a link, a browser); 130 after Ctrl-C.
"""

from __future__ import annotations

import sys
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.delay import chapter5, goals, plan, sound
from e2e.delay.names import profiles
from e2e.link import DRIVE
from e2e.measure.command import NOT_RUN, parser_of, run
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.suite import PAGE, SERVER, Suite

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from e2e.delay.apparatus import Apparatus
    from e2e.delay.cell import Cell
    from e2e.measure.suite import Case

ABOUT: Final = "Measure WAX and its peers over shaped networks, as chapter 5 of the thesis."


def main(words: Sequence[str] | None = None) -> int:
    arguments = _arguments(words)
    try:
        cells = [] if arguments.emulator else _cells(arguments)
        if arguments.list:
            return _list(arguments, cells)
        return _measure(arguments, cells)
    except NotRunError as error:
        print(f"lab not run: {error}", file=sys.stderr)
        return NOT_RUN
    except MeasureError as error:
        print(f"lab: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"lab: {error}; name another folder by --out", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _measure(arguments: argparse.Namespace, cells: Sequence[Cell]) -> int:
    from e2e.delay.apparatus import Apparatus  # noqa: PLC0415  # browsers and media take their time

    name = _name(arguments)
    # The cells that were chosen and repeated are the suite: the library takes all of them, once.
    arguments.only = [f"*{one}*" for one in arguments.only or ()] if arguments.emulator else None
    arguments.n = None
    with Apparatus(arguments.out / name, strict=arguments.quick) as apparatus:
        if cells:
            apparatus.check(cells[0])
            _say(arguments, cells)
        cases = _cases(arguments, cells, apparatus)
        status = run(_suite(name, arguments, cases), arguments)
    if cells and not (arguments.goals or arguments.sound):
        from e2e.delay import report  # noqa: PLC0415  # so do plots

        print(report.write(arguments.out / name, cells), file=sys.stderr)
    # Link and browser are there: what was not run is a peer, another browser, or the voice.
    return 0 if status == NOT_RUN and cells else status


def _cases(
    arguments: argparse.Namespace, cells: Sequence[Cell], apparatus: Apparatus
) -> list[Case]:
    emulated = profiles() if arguments.emulator else []
    if arguments.long:
        emulated = list(dict.fromkeys(cell.profile for cell in cells))
    return [
        *(() if arguments.quick else (apparatus.own_error(),)),
        *(apparatus.emulator(profile) for profile in emulated),
        *(apparatus.case(cell) for cell in cells),
    ]


def _suite(name: str, arguments: argparse.Namespace, cases: Sequence[Case]) -> Suite:
    judged = goals if arguments.goals else sound if arguments.sound else chapter5
    return Suite(
        name=name,
        about=ABOUT,
        measures=(*SERVER, *PAGE),
        columns=judged.COLUMNS,
        cases=tuple(cases),
        derive=list if arguments.emulator else judged.derive,
        notes=judged.NOTES,
    )


def _name(arguments: argparse.Namespace) -> str:
    """Name the suite; a long or short form has results of its own, for another file or none."""
    if arguments.emulator:
        return "emulator"
    form = "-quick" if arguments.quick else "-long" if arguments.long else ""
    name = "goals" if arguments.goals else "sound" if arguments.sound else "lab"
    return f"{name}{form}"


def _cells(arguments: argparse.Namespace) -> list[Cell]:
    """Plan what is asked for; raises `MeasureError` where a pattern matches no cell."""
    only = arguments.only or []
    everything = _planned(arguments, [])
    for pattern in only:
        if not any(plan.matches(cell, [pattern]) for cell in everything):
            raise MeasureError(
                f"no cell's name has {pattern} in it{_near(pattern, everything)}; "
                "--list says their names"
            )
    return _planned(arguments, only)


def _near(pattern: str, cells: Sequence[Cell]) -> str:
    """Say which part of a name was meant, where one of them is close."""
    parts = sorted({part for cell in cells for part in cell.variant.split("/")})
    for word in pattern.split("/"):
        near = get_close_matches(word, parts, 1)
        if word not in parts and near:
            return f", did you mean {near[0]}"
    return ""


def _planned(arguments: argparse.Namespace, only: Sequence[str]) -> list[Cell]:
    if arguments.quick:
        return plan.quick(repeats=arguments.n or 1, only=only)
    if arguments.goals:
        repeats = arguments.n or goals.REPEATS
        return goals.planned(long=arguments.long, repeats=repeats, only=only)
    if arguments.sound:
        repeats = arguments.n or sound.REPEATS
        return sound.planned(drives=_drives(arguments.drives), repeats=repeats, only=only)
    return plan.full(
        seconds=plan.LONG_SECONDS if arguments.long else plan.SECONDS,
        repeats=arguments.n or (plan.LONG_REPEATS if arguments.long else 1),
        only=only,
        trimmed=_is_trimmed(arguments),
    )


def _drives(folder: Path | None) -> list[str]:
    """Find the recorded drives in a folder; raises `MeasureError` where there is none."""
    if folder is None:
        return []
    found = sorted(str(path.resolve()) for path in folder.glob(f"*{DRIVE}"))
    if not found:
        raise MeasureError(f"{folder} has no recorded drive: no file ends in {DRIVE}")
    return found


def _is_trimmed(arguments: argparse.Namespace) -> bool:
    """Whether cells are left out so that the hour is kept, which nobody else has to keep."""
    others = (arguments.quick, arguments.long, arguments.goals, arguments.sound, arguments.only)
    return not any(others)


def _list(arguments: argparse.Namespace, cells: Sequence[Cell]) -> int:
    for cell in cells:
        print(cell.key)
    _say(arguments, cells)
    if _is_trimmed(arguments):
        for line in plan.TRIMMED:
            print(f"left out: {line}", file=sys.stderr)
    return 0


def _say(arguments: argparse.Namespace, cells: Sequence[Cell]) -> None:
    minutes = plan.estimate_s(cells, own_error=not arguments.quick) / 60
    number = f"{len(cells)} cell{'' if len(cells) == 1 else 's'}"
    print(f"{number}, about {minutes:.0f} min", file=sys.stderr)


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = parser_of("python -m e2e.delay", ABOUT)
    parser.add_argument("--resume", action="store_true", help="only what has no result yet")
    parser.add_argument(
        "--goals",
        action="store_true",
        help="what is promised, 3 times beside the peers, about 40 minutes; with --long the cells "
        "of 5 and 10 minutes and both roles",
    )
    parser.add_argument(
        "--sound",
        action="store_true",
        help="the sound at the ear, by our player, the browser's and the peers, 3 times for 60 s, "
        "and once for half an hour, about two and a half hours",
    )
    parser.add_argument(
        "--drives",
        type=Path,
        metavar="FOLDER",
        help="with --sound also over recorded cellular links: mahimahi's traces, NAME.down and "
        "NAME.up",
    )
    parser.add_argument(
        "--emulator",
        action="store_true",
        help="verify the emulator alone, every profile with packets of its own, 3 minutes",
    )
    arguments = parser.parse_args(words)
    if arguments.n is not None and not 1 <= arguments.n <= 100:
        parser.error(f"--n {arguments.n}: allowed is a whole number from 1 to 100")
    if sum((arguments.quick, arguments.long, arguments.emulator)) > 1:
        parser.error("give one of --quick, --long and --emulator")
    if arguments.goals and arguments.sound:
        parser.error("give one of --goals and --sound")
    if arguments.quick and (arguments.goals or arguments.sound):
        parser.error("goals are judged by three repetitions; give --goals or --sound alone")
    if arguments.drives and not arguments.sound:
        parser.error("only --sound measures over --drives")
    return arguments


if __name__ == "__main__":
    sys.exit(main())
