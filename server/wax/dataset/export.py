"""Exports the tape as a dataset: reads a turn at a time, and writes its episodes."""

from __future__ import annotations

import errno
import os
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import av

from wax.dataset.episodes import LeftOut
from wax.dataset.frames import Grid, Timeline
from wax.dataset.lerobot import ABOUT, Layout, LeRobotFolder
from wax.dataset.pictures import decoded, packets
from wax.dataset.statistics import PictureStatistics
from wax.dataset.survey import DRIVING_VIEW, survey
from wax.dataset.video_file import CODEC, VideoFile
from wax.errors import StateError, reason_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from av.video.frame import VideoFrame

    from wax.dataset.episodes import Episode
    from wax.dataset.frames import DatasetFrame
    from wax.dataset.survey import Survey
    from wax.tape.selection import Selection

_NICENESS: Final = 19
GAP_S: Final = 0.5
"""A longer time without a picture is a gap, which ends an episode."""
_MEASURED_S: Final = 10.0
"""The rate of the tape is that of this much of its first episode."""
_FULL: Final = (errno.ENOSPC, errno.EDQUOT)
_SAID: Final = 10
"""At most so many reasons are printed; the dataset has all."""

ABOUT_COLUMNS: Final = {
    "action": "the set-point that was in force when the picture was captured: metres and radians a"
    " second; ahead, to the left and counter-clockwise are positive",
    "observation.state": "what the robot had reported last: metres, radians, volts; moving is 0 or"
    " 1, bumpers a bit for each, battery_fraction 0 (empty) to 1",
    "wax.gate": "0: the command passed, 1: the robot was slowed, 2: it was held",
    "wax.held": "whether the operator held any control",
    "wax.captured_s": "when the picture was captured, in seconds since 1970; where this repeats, a"
    " picture is missing on the tape, and the one before is repeated",
}


@dataclass(frozen=True, slots=True)
class Options:
    """What a user can choose; episodes that are shorter than `drop_under_s` are left out.

    With `acts_next` a frame's action is that of the frame after it, and the last frame is left out.
    """

    camera: str = DRIVING_VIEW
    fps: int | None = None
    acts_next: bool = False
    joins: bool = False
    drop_under_s: float = 1.0
    task: str = ""


def export(
    selection: Selection, folder: Path, options: Options, *, tell: Callable[[str], None]
) -> str:
    """Write the dataset and return what it has; `tell` hears the progress.

    Raises `StateError` with what to do; the same export then goes on where it was.
    """
    os.nice(_NICENESS)
    found = survey(selection, camera=options.camera, joins=options.joins)
    if not found.episodes:
        raise StateError("\n".join(["nobody drove in what is recorded", *_said(found.left_out)]))
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
        if getattr(error, "errno", None) in _FULL:
            raise StateError(
                f"{folder}: the disk is full; free some, and give the same command again: it goes"
                " on from here"
            ) from error
        raise StateError(f"{folder}: cannot be written: {reason_of(error)}") from error


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
        writer = _PieceWriter(dataset, layout, options, piece)
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
    dataset.finish({"columns": ABOUT_COLUMNS, "asked": asdict(options)})
    lines = [f"{folder}: {len(episodes)} episodes, {_length(episodes, layout)}"]
    return "\n".join([*lines, *_said(left_out)])


class _PieceWriter:
    """Writes the episodes of one piece of a turn: more than one if pictures are missing."""

    def __init__(
        self, dataset: LeRobotFolder, layout: Layout, options: Options, piece: Episode
    ) -> None:
        self._dataset = dataset
        self._layout = layout
        self._options = options
        self._piece = piece
        self._open: _OpenEpisode | None = None
        self.episodes: list[dict[str, Any]] = []
        self.left_out: list[LeftOut] = []

    def write(self, found: Survey) -> None:
        begin_s, end_s = self._piece.begin_s, self._piece.end_s
        events = found.events(begin_s, end_s)
        timeline = Timeline(events, actions=found.actions, observed=found.observed)
        files = []
        for part in found.within(begin_s, end_s):
            if part.media.size == self._layout.size:
                files.append(part.media)
            else:
                width, height = part.media.size
                self._leave_out(part.began_s, part.ended_s, f"its pictures are {width}×{height}")
        grid: Grid[VideoFrame] = Grid(self._layout.fps)
        newest_s: float | None = None
        for captured_s, picture in decoded(files, begin_s, end_s, self._leave_out_damaged):
            if newest_s is not None and captured_s - newest_s > GAP_S:
                self._add(timeline, grid.finish())
                self._finish_episode()
                self._leave_out(newest_s, captured_s, "the tape has a gap")
                grid = Grid(self._layout.fps)
            self._add(timeline, grid.add(captured_s, picture))
            newest_s = captured_s
        self._add(timeline, grid.finish())
        self._finish_episode()

    def _add(self, timeline: Timeline, pictures: Iterator[tuple[float, VideoFrame]]) -> None:
        for captured_s, picture in pictures:
            frame = timeline.frame(captured_s)
            if frame is None:
                continue
            if self._open is None:
                path = self._dataset.video_path(len(self._dataset.journal.episodes))
                self._open = _OpenEpisode(path, self._layout, self._options)
            self._open.add(frame, picture)

    def _finish_episode(self) -> None:
        episode, self._open = self._open, None
        if episode is None:
            return
        frames = episode.close()
        length_s = len(frames) / self._layout.fps
        if len(frames) < 2 or length_s < self._options.drop_under_s:
            episode.path.unlink(missing_ok=True)
            self._leave_out(self._piece.begin_s, self._piece.end_s, f"lasts for {length_s:.1f} s")
            return
        self.episodes.append(
            self._dataset.add_episode(
                frames,
                task=self._piece.task or self._options.task,
                turn=self._piece.turn,
                pictures=episode.pictures.result(),
            )
        )

    def _leave_out(self, begin_s: float, end_s: float, why: str) -> None:
        self.left_out.append(LeftOut(begin_s, end_s, f"turn {self._piece.turn}: {why}"))

    def _leave_out_damaged(self, why: str) -> None:
        self._leave_out(self._piece.begin_s, self._piece.end_s, why)


class _OpenEpisode:
    """An episode whose frames are being written."""

    def __init__(self, path: Path, layout: Layout, options: Options) -> None:
        self.path = path
        self.pictures = PictureStatistics()
        self._acts_next = options.acts_next
        self._fps = layout.fps
        self._video = VideoFile(path, fps=layout.fps, size=layout.size)
        self._frames: list[DatasetFrame] = []
        self._waiting: tuple[DatasetFrame, VideoFrame] | None = None

    def add(self, frame: DatasetFrame, picture: VideoFrame) -> None:
        if not self._acts_next:
            self._write(frame, picture)
            return
        before, self._waiting = self._waiting, (frame, picture)
        if before is not None:
            self._write(before[0].acting_as(frame), before[1])

    def close(self) -> list[DatasetFrame]:
        self._video.close()
        return self._frames

    def _write(self, frame: DatasetFrame, picture: VideoFrame) -> None:
        self._video.add(picture)
        if len(self._frames) % self._fps == 0:
            self.pictures.add(picture)
        self._frames.append(frame)


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
