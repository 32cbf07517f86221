"""``python -m e2e.lab``: chapter 5 again, over shaped networks; a folder with all that was found.

Exit status: 0 when every cell was measured, if only to find that no picture comes, or cannot be on
this machine; 1 when one was lost, or with --quick has no picture; with one sentence 77 when this
machine has not what the lab needs (a link, a browser), and 2 when the lab fails or what was asked
for is not there; 130 after Ctrl-C.
"""

from __future__ import annotations

import argparse
import asyncio
import signal
import sys
from pathlib import Path
from typing import Final

from e2e.lab import goals, plan
from e2e.lab.errors import LabError, NotRunError
from e2e.lab.link import LinkError, UnavailableError
from e2e.lab.progress import count, duration
from e2e.lab.wanted import Wanted

NOT_RUN: Final = 77
"""What automake takes for a test that was skipped; argparse and a lab that fails end with 2."""


def main() -> int:
    arguments = _arguments()
    try:
        if arguments.list:
            return _list(_wanted(arguments))
        if arguments.resume is None:
            _wanted(arguments).cells()  # what is wrong is told before all is loaded
        return asyncio.run(_run(arguments))
    except (UnavailableError, NotRunError) as error:
        print(f"lab not run: {error}", file=sys.stderr)
        return NOT_RUN
    except (LabError, LinkError) as error:
        print(f"lab: {error}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, asyncio.CancelledError):
        return 130


async def _run(arguments: argparse.Namespace) -> int:
    from e2e.lab import session  # noqa: PLC0415  # browsers, media and plots take their time

    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    assert task is not None
    loop.add_signal_handler(signal.SIGTERM, task.cancel)  # as Ctrl-C: nothing is left behind either
    try:
        if arguments.resume is not None:
            return await session.resume(Path(arguments.resume) if arguments.resume else None)
        return await session.begin(_wanted(arguments))
    except asyncio.CancelledError:
        # The terminal's Ctrl-C ended the browser's driver too, which has to say something about it.
        loop.set_exception_handler(lambda *_: None)
        raise


def _list(wanted: Wanted) -> int:
    cells = wanted.cells()
    for cell in cells:
        print(cell.key)
    takes_s = plan.estimate_s(cells, own_error=not wanted.quick, emulator=wanted.long)
    print(f"{count(cells)}, about {duration(takes_s)}", file=sys.stderr)
    if wanted.is_trimmed:
        for line in plan.TRIMMED:
            print(f"left out: {line}", file=sys.stderr)
    return 0


def _wanted(arguments: argparse.Namespace) -> Wanted:
    return Wanted(
        quick=arguments.quick,
        long=arguments.long,
        goals=arguments.goals,
        only=arguments.only,
        repeats=arguments.repeat or _repeats(arguments),
        out=arguments.out,
    )


def _repeats(arguments: argparse.Namespace) -> int:
    if arguments.goals:
        return goals.REPEATS
    return plan.LONG_REPEATS if arguments.long else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.lab",
        description="Measure WAX and its peers over shaped networks, as chapter 5 of the thesis.",
    )
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--quick", action="store_true", help="under 4 minutes, touches every part")
    length.add_argument(
        "--long",
        action="store_true",
        help="all cells 3 times for 60 s and the emulator verified before, about a night long",
    )
    parser.add_argument(
        "--goals",
        action="store_true",
        help="what is promised, 3 times beside the peers, about 35 minutes; with --long the cells "
        "of 5 and 10 minutes and both roles",
    )
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="PATTERN",
        help="cells whose name has this in it, as E1/lan or lan/*/face; may be given again",
    )
    parser.add_argument("--repeat", type=_number, metavar="N", help="how often each is measured")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where the results go")
    parser.add_argument(
        "--resume",
        nargs="?",
        const="",
        metavar="FOLDER",
        help="do what that run, or the newest unfinished one, has left or failed to do",
    )
    parser.add_argument("--list", action="store_true", help="say what would be measured")
    arguments = parser.parse_args()
    given = [arguments.quick, arguments.long, arguments.only, arguments.repeat, arguments.out]
    if arguments.resume is not None and any([*given, arguments.goals]):
        parser.error("a run is resumed with what it was begun with; give --resume alone")
    if arguments.quick and arguments.goals:
        parser.error("the goals are judged by three repetitions; give --goals without --quick")
    return arguments


def _number(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 100:
        raise argparse.ArgumentTypeError(f"got {text}; allowed is a whole number from 1 to 100")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
