"""Writes the episodes of one piece of a turn: more than one if pictures are missing."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, TypeVar

import av

from wax.dataset.episodes import LeftOut
from wax.dataset.frames import Grid, Timeline, are_on_grid
from wax.dataset.parts import DRIVING_VIEW
from wax.dataset.pictures import decoded, packets
from wax.dataset.sound_file import copy_sound
from wax.dataset.statistics import PictureStatistics
from wax.dataset.video_file import CODEC, CopiedVideo, VideoFile

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from av.packet import Packet
    from av.video.stream import VideoStream

    from wax.dataset.episodes import Episode
    from wax.dataset.frames import DatasetFrame
    from wax.dataset.lerobot import Layout, LeRobotFolder
    from wax.dataset.pictures import PictureFile
    from wax.dataset.survey import Survey, SurveyedPart

_Picture = TypeVar("_Picture")

GAP_S: Final = 0.5
"""A longer time without a picture is a gap, which ends an episode."""


@dataclass(frozen=True, slots=True)
class Options:
    """What a user can choose; episodes that are shorter than `drop_under_s` are left out.

    With `copies`, H.264 pictures are copied where there is one for each frame; then an episode
    begins with its first keyframe. With `acts_next` a frame's action is that of the frame after it,
    and the last frame is left out.
    """

    camera: str = DRIVING_VIEW
    fps: int | None = None
    acts_next: bool = False
    joins: bool = False
    copies: bool = False
    sound: bool = False
    drop_under_s: float = 1.0
    task: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    """The units of the robot's gauges by their names."""
    choices: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """What one chooses from, by the names of the controls that are a choice."""


class PieceWriter:
    """Writes the episodes of one piece of a turn: more than one if pictures are missing."""

    def __init__(
        self, dataset: LeRobotFolder, layout: Layout, options: Options, piece: Episode
    ) -> None:
        self._dataset = dataset
        self._layout = layout
        self._options = options
        self._piece = piece
        self._open: _OpenEpisode | None = None
        self._copied_like: Path | None = None
        self._parts: list[SurveyedPart] = []
        self.episodes: list[dict[str, Any]] = []
        self.left_out: list[LeftOut] = []

    def write(self, found: Survey) -> None:
        begin_s, end_s = self._piece.begin_s, self._piece.end_s
        self._parts = found.within(begin_s, end_s)
        events = found.events(begin_s, end_s)
        timeline = Timeline(events, actions=found.actions, observed=found.observed)
        files = []
        for part in self._parts:
            if part.media.size == self._layout.size:
                files.append(part.media)
            else:
                width, height = part.media.size
                self._leave_out(part.began_s, part.ended_s, f"its pictures are {width}×{height}")
        copied_s = self._copied_from(files, timeline) if self._options.copies else None
        if copied_s is None:
            self._add_all(timeline, decoded(files, begin_s, end_s, self._leave_out_damaged))
        else:
            self._copied_like = files[0].path
            self._leave_out(begin_s, copied_s, "lies before a keyframe, with which a copy begins")
            self._add_all(timeline, _packets(files, copied_s, end_s))

    def _copied_from(self, files: Sequence[PictureFile], timeline: Timeline) -> float | None:
        """Return the keyframe from which pictures can be copied; None if they must be encoded."""
        if {one.codec for one in files} != {CODEC} or len({one.header for one in files}) > 1:
            return None
        try:
            pictures = _packets(files, self._piece.begin_s, self._piece.end_s)
            found = [(at_s, packet.is_keyframe) for at_s, packet in pictures]
        except (av.FFmpegError, OSError):
            return None
        begins = (n for n, (at_s, is_key) in enumerate(found) if is_key and timeline.frame(at_s))
        begin = next(begins, len(found))
        times_s = [at_s for at_s, _ in found[begin:]]
        return times_s[0] if times_s and are_on_grid(times_s, self._layout.fps) else None

    def _add_all(self, timeline: Timeline, pictures: Iterable[tuple[float, _Picture]]) -> None:
        grid: Grid[_Picture] = Grid(self._layout.fps)
        newest_s: float | None = None
        for captured_s, picture in pictures:
            if newest_s is not None and captured_s - newest_s > GAP_S:
                self._add(timeline, grid.finish())
                self._finish_episode()
                self._leave_out(newest_s, captured_s, "the tape has a gap")
                grid = Grid(self._layout.fps)
            self._add(timeline, grid.add(captured_s, picture))
            newest_s = captured_s
        self._add(timeline, grid.finish())
        self._finish_episode()

    def _add(self, timeline: Timeline, pictures: Iterator[tuple[float, _Picture]]) -> None:
        for captured_s, picture in pictures:
            frame = timeline.frame(captured_s)
            if frame is None:
                continue
            if self._open is None:
                path = self._dataset.video_path(len(self._dataset.journal.episodes))
                self._open = _OpenEpisode(path, self._video(path), self._options)
            self._open.add(frame, picture)

    def _video(self, path: Path) -> VideoFile | CopiedVideo:
        if self._copied_like is not None:
            return CopiedVideo(path, fps=self._layout.fps, like=self._copied_like)
        return VideoFile(path, fps=self._layout.fps, size=self._layout.size)

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
        if self._options.sound:
            taped = [(one.sound, one.began_s) for one in self._parts if one.sound is not None]
            path = self._dataset.sound_path(len(self._dataset.journal.episodes))
            copy_sound(taped, path, frames[0].captured_s, frames[0].captured_s + length_s)
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

    def __init__(self, path: Path, video: VideoFile | CopiedVideo, options: Options) -> None:
        self.path = path
        self.pictures = PictureStatistics()
        self._acts_next = options.acts_next
        self._video = video
        self._frames: list[DatasetFrame] = []
        self._waiting: tuple[DatasetFrame, Any] | None = None

    def add(self, frame: DatasetFrame, picture: Any) -> None:
        if not self._acts_next:
            self._write(frame, picture)
            return
        before, self._waiting = self._waiting, (frame, picture)
        if before is not None:
            self._write(before[0].acting_as(frame), before[1])

    def close(self) -> list[DatasetFrame]:
        self._video.close()
        return self._frames

    def _write(self, frame: DatasetFrame, picture: Any) -> None:
        self._video.add(picture, self.pictures)
        self._frames.append(frame)


def _packets(
    files: Iterable[PictureFile], begin_s: float, end_s: float
) -> Iterator[tuple[float, Packet[VideoStream]]]:
    """Yield the pictures from `begin_s` until `end_s` as they are on the tape."""
    for file in files:
        for at_s, packet in packets(file, begin_s, end_s):
            if at_s >= begin_s:
                yield at_s, packet
