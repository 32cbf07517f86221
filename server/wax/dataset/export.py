"""Exports the tape as a dataset: reads a turn at a time, and writes its episodes."""

from __future__ import annotations

from dataclasses import asdict
from datetime import UTC, datetime
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import av

from wax.dataset.lerobot import ABOUT, Layout, LeRobotFolder
from wax.dataset.parts import cannot_write
from wax.dataset.pictures import packets
from wax.dataset.piece_writer import PieceWriter
from wax.dataset.survey import survey
from wax.dataset.video_file import CODEC
from wax.errors import StateError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from wax.dataset.episodes import LeftOut
    from wax.dataset.piece_writer import Options
    from wax.dataset.survey import Survey
    from wax.tape.selection import Selection

_MEASURED_S: Final = 10.0
"""The rate of the tape is that of this much of its first episode."""
_SAID: Final = 10
"""At most so many reasons are printed; the dataset has all."""

ABOUT_COLUMNS: Final = {
    "action": "the set-point that was in force when the picture was captured: metres and radians a"
    " second; ahead, to the left and counter-clockwise are positive; axis.NAME is where it was sent"
    " last, from -1 to 1; control.NAME is 1 while it is on or held, a slider's value, or a choice's"
    " number, from 0, in NAME's list under choices; both are 0 before they were used",
    "observation.state": "what the robot had reported last: metres, radians, volts; moving is 0 or"
    " 1, bumpers a bit for each, battery_fraction 0 (empty) to 1; the unit of gauge.NAME is that of"
    " NAME under gauges",
    "wax.gate": "0: the command passed, 1: the robot was slowed, 2: it was held",
    "wax.held": "whether the operator held any control",
    "wax.captured_s": "when the picture was captured, in seconds since 1970; where this repeats, a"
    " picture is missing on the tape, and the one before is repeated",
}


def export(
    selection: Selection, folder: Path, options: Options, *, tell: Callable[[str], None]
) -> str:
    """Write the dataset and return what it has; `tell` hears the progress.

    Raises `StateError` with what to do; the same export then goes on where it was.
    """
    found = survey(selection, camera=options.camera, joins=options.joins)
    if not found.episodes:
        raise StateError(
            "\n".join(["no turn is recorded that can be exported", *_said(found.left_out)])
        )
    layout = Layout(
        camera=options.camera,
        codec=CODEC,
        size=found.within(found.episodes[0].begin_s, found.episodes[0].end_s)[0].media.size,
        fps=options.fps or _rate(found),
        actions=found.actions,
        observed=found.observed,
    )
    try:
        return _export(found, layout, folder, options, tell)
    except (OSError, av.FFmpegError) as error:
        raise cannot_write(folder, error) from error


def _export(
    found: Survey, layout: Layout, folder: Path, options: Options, tell: Callable[[str], None]
) -> str:
    dataset = LeRobotFolder(folder, layout, asdict(options))
    pieces = [[one.turn, one.begin_s, one.end_s] for one in found.episodes]
    done = len(dataset.journal.pieces)
    if dataset.journal.pieces != pieces[:done]:
        raise StateError(
            f"{dataset.partial}: the tape has changed since this export was interrupted; delete it,"
            " and start anew"
        )
    if done:
        tell(f"Going on after {done} of {len(pieces)} turns.")
    for number, piece in enumerate(found.episodes[done:], start=done + 1):
        writer = PieceWriter(dataset, layout, options, piece)
        writer.write(found)
        dataset.finish_piece(
            pieces[number - 1], writer.episodes, [_told(one) for one in writer.left_out]
        )
        tell(f"{number} of {len(pieces)}: turn {piece.turn}, {_length(writer.episodes, layout)}")
    episodes = dataset.journal.episodes
    left_out = [*map(_told, found.left_out), *dataset.journal.left_out]
    if not episodes:
        raise StateError("\n".join(["there is nothing to export", *_said(left_out)]))
    dataset.journal.left_out = left_out
    asked = asdict(options)
    names = {"gauges": asked.pop("units"), "choices": asked.pop("choices")}
    dataset.finish({"columns": ABOUT_COLUMNS, **names, "asked": asked})
    lines = [f"{folder}: {len(episodes)} episodes, {_length(episodes, layout)}"]
    return "\n".join([*lines, *_said(left_out)])


def _rate(found: Survey) -> int:
    """Return how many pictures a second the tape has."""
    first = found.episodes[0]
    end_s = min(first.end_s, first.begin_s + _MEASURED_S)
    files = (one.media for one in found.within(first.begin_s, end_s))
    times_s = [at_s for one in files for at_s, _ in packets(one, first.begin_s, end_s)]
    if len(times_s) < 2:
        raise StateError("the first turn has no pictures; choose another time with --from")
    return max(1, round(1 / median(after - before for before, after in pairwise(times_s))))


def _length(episodes: Sequence[dict[str, Any]], layout: Layout) -> str:
    frames = sum(one["length"] for one in episodes)
    return f"{frames} frames, {frames / layout.fps:.1f} s"


def _told(left_out: LeftOut) -> dict[str, Any]:
    began = datetime.fromtimestamp(left_out.begin_s, UTC).isoformat(timespec="milliseconds")
    seconds = round(left_out.end_s - left_out.begin_s, 3)
    return {"began": began, "seconds": seconds, "why": left_out.why}


def _said(left_out: Sequence[dict[str, Any] | LeftOut]) -> list[str]:
    """Return lines that say what was left out."""
    told = [one if isinstance(one, dict) else _told(one) for one in left_out]
    lines = [f"  left out: {one['began']}, {one['seconds']:.1f} s: {one['why']}" for one in told]
    more = len(lines) - _SAID
    return [*lines[:_SAID], *([f"  … and {more} more, in {ABOUT}"] if more > 0 else [])]
