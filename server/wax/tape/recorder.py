"""Writes the tape in a thread of its own: whatever the disk does, nobody waits for it.

What is to be written waits in a queue. When that is full, the disk is too slow: then all is left
out until the queue is empty again, a new part begins, and what is missing is written down.

A killed server loses what came after the last `FLUSH_S`, a power cut what came after the last sync,
which follow each other by `SYNC_S`. Each costs the disk some writes beside what is recorded; how
many depends on its file system. A memory card that needs long for one is asked less often, so that
three quarters of the time are left for writing.
"""

from __future__ import annotations

import shutil
import threading
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final

import structlog

from wax.encode.encoded import EncodedPicture, EncodedSound
from wax.errors import StateError, WaxError, reason_of
from wax.protocol.tape_events import Missed
from wax.sentence import Sentence, says
from wax.tape.retention import retain
from wax.tape.segment import WRITE_ERRORS, Segment
from wax.tape.segment_plan import SegmentPlan

if TYPE_CHECKING:
    from collections.abc import Hashable

    from wax.clock import Clock
    from wax.config.recording import RecordingSettings
    from wax.protocol.tape_events import TapeEvent
    from wax.tape.camera_files import CameraFormat
    from wax.tape.media_file import Codec
    from wax.tape.retention import Keeper
    from wax.tape.segment_plan import Kind
    from wax.tape.shelf import Shelf

_LOG = structlog.get_logger(__name__)

MOST_WAITING: Final = 4000
"""Ten seconds of pictures, sound and driving."""
FLUSH_S: Final = 0.4
SYNC_S: Final = 0.8
_SYNC_SHARE: Final = 0.25
_WAIT_S: Final = 0.2
RETRY_S: Final = 20.0
_PRUNE_S: Final = 600.0
_ROOM_S: Final = 5.0
_GB: Final = 1e9

DISK_FULL: Final = Sentence("tape.disk_full")
TAPE_FULL: Final = Sentence("tape.full")
TOO_SLOW: Final = Sentence("tape.too_slow")


class TapeError(WaxError):
    """Why nothing can be recorded now."""


@dataclass(frozen=True, slots=True)
class Format:
    """What picture and sound are like; `size` is None without a camera.

    `sound_channels` is how many the sound may have: some packets may have fewer. `cameras` are
    those beside the driving view.
    """

    codec: Codec
    size: tuple[int, int] | None
    has_sound: bool
    keyframe_interval_s: float
    sound_channels: int = 1
    cameras: tuple[CameraFormat, ...] = ()


@dataclass(frozen=True, slots=True)
class _CameraPicture:
    camera: int
    picture: EncodedPicture

    @property
    def captured_s(self) -> float:
        return self.picture.captured_s


@dataclass(frozen=True, slots=True)
class _Event:
    event: TapeEvent
    at_s: float
    lasts_as: Hashable


@dataclass(frozen=True, slots=True)
class _Keep:
    since_s: float
    by: Keeper


@dataclass(frozen=True, slots=True)
class _Forget:
    """What lasted so lasts no longer."""

    lasts_as: Hashable


@dataclass(frozen=True, slots=True)
class _Resume:
    """Here something is missing, since this time."""

    since_s: float


_Recorded = EncodedPicture | _CameraPicture | EncodedSound | _Event
_Item = _Recorded | _Keep | _Forget | _Resume


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    """How recording goes; `parts` and their bytes are those of the last look into the folder.

    `waiting` is what is not written yet, `left_out` what never will be, since the disk was too slow
    or could not be written: pictures, packets of sound and events.
    """

    problem: Sentence | None
    parts: int
    parts_bytes: int
    waiting: int
    left_out: int


class Recorder:
    """`start` it, then put from the event loop; nothing here waits or raises."""

    def __init__(
        self,
        shelf: Shelf,
        *,
        settings: RecordingSettings,
        format: Format,  # noqa: A002  # what it is
        clock: Clock,
    ) -> None:
        self._shelf = shelf
        self._settings = settings
        self._format = format
        self._clock = clock
        # One offset for good: times of events must not jump with the machine's clock.
        self._zero_ns = clock.wall_ms() * 1_000_000 - round(clock.now_s() * 1e9)
        self._queue: SimpleQueue[_Item | None] = SimpleQueue()
        self._behind_since_s: float | None = None
        self._gave_up: Sentence | None = None
        self._not_put = 0
        self._thread = threading.Thread(target=self._run, name="tape", daemon=True)
        # All below is written by the thread only.
        self._trouble: Sentence | None = None
        self._not_written = 0
        self._shelved = (0, 0)
        self._is_over = False
        self._segment: Segment | None = None
        self._plan = SegmentPlan(
            segment_s=settings.segment_s,
            keyframe_interval_s=format.keyframe_interval_s,
            has_camera=format.size is not None,
        )
        self._lasting: dict[Hashable, TapeEvent] = {}
        self._flushed_s = self._pruned_s = self._measured_s = float("-inf")
        self._sync_due_s = float("-inf")
        self._logged: Sentence | None = None

    def start(self) -> None:
        self._thread.start()

    def request_stop(self) -> None:
        self._queue.put(None)

    def stop(self, within_s: float = 1.0) -> None:
        """Write what waits, and end; gives up after `within_s`."""
        self.request_stop()
        if self._thread.is_alive():
            self._thread.join(within_s)

    def picture(self, picture: EncodedPicture) -> None:
        self._put(picture)

    def camera(self, camera: int, picture: EncodedPicture) -> None:
        """Record a picture of a camera beside the driving view; they count from 1."""
        self._put(_CameraPicture(camera, picture))

    def waits_for(self, camera: int) -> bool:
        """Whether a part is being written in which this camera is missing until its keyframe."""
        segment = self._segment
        return segment is not None and not segment.has_camera(camera)

    def sound(self, sound: EncodedSound) -> None:
        self._put(sound)

    def event(self, event: TapeEvent, at_s: float, lasts_as: Hashable = None) -> None:
        """Record an event; the newest of each `lasts_as` is repeated in each new part.

        So that a part can be read without those before it.
        """
        self._put(_Event(event, at_s, lasts_as))

    def forget(self, lasts_as: Hashable) -> None:
        """Repeat this no more."""
        self._queue.put(_Forget(lasts_as))

    def give_up(self, why: Sentence) -> None:
        """Record nothing more until the server starts again."""
        self._gave_up = why

    def keep(self, since_s: float, by: Keeper) -> None:
        """Keep what was recorded since then."""
        self._queue.put(_Keep(since_s, by))

    @property
    def problem(self) -> Sentence | None:
        """Why nothing is recorded now; None while something is."""
        behind = None if self._behind_since_s is None else TOO_SLOW
        return self._gave_up or self._trouble or behind

    @property
    def waiting(self) -> int:
        """How much is not written yet."""
        return self._queue.qsize()

    def status(self) -> RecorderStatus:
        parts, parts_bytes = self._shelved
        return RecorderStatus(
            problem=self.problem,
            parts=parts,
            parts_bytes=parts_bytes,
            waiting=self.waiting,
            left_out=self._not_put + self._not_written,
        )

    def _put(self, item: _Item) -> None:
        if self._behind_since_s is None and self.waiting >= MOST_WAITING:
            self._behind_since_s = self._clock.now_s()
        elif self._behind_since_s is not None and self.waiting == 0:
            self._queue.put(_Resume(self._behind_since_s))
            self._behind_since_s = None
        if self._behind_since_s is None and self._gave_up is None:
            self._queue.put(item)
        else:
            self._not_put += 1

    # --- the thread --------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._is_over:
            try:
                self._record()
            except (TapeError, StateError, *WRITE_ERRORS) as error:
                self._fails(_why(error))
            except Exception:
                _LOG.exception("the tape failed")
                self._fails(Sentence("tape.failed"))
            if not self._is_over:
                self._leave_out(RETRY_S)

    def _record(self) -> None:
        """Write until the end; raises where nothing can be written."""
        try:
            self._shelf.prepare()
            self._prune()
            self._check_room()
            self._trouble = None
            while not self._is_over:
                self._take()
                self._look_after()
        finally:
            self._end()

    def _take(self) -> None:
        """Write the next item, if one comes soon."""
        try:
            item = self._queue.get(timeout=_WAIT_S)
        except Empty:
            return
        match item:
            case None:
                self._is_over = True
            case _Keep():
                self._mark(item)
            case _Forget():
                self._lasting.pop(item.lasts_as, None)
            case _Resume():
                self._resume(item)
            case EncodedPicture():
                self._write(item, "keyframe" if item.keyframe else "picture", item.captured_s)
            case _CameraPicture() | EncodedSound():
                self._write(item, "other", item.captured_s)
            case _Event():
                self._write(item, "other", item.at_s)
                if item.lasts_as is not None:
                    self._lasting[item.lasts_as] = item.event

    def _write(self, item: _Recorded, kind: Kind, at_s: float) -> None:
        step = self._plan.decide(kind, at_s)
        if step == "begin":
            self._begin(at_s, has_picture=kind == "keyframe")
        if step == "skip" or self._segment is None:
            return
        match item:
            case EncodedPicture():
                self._segment.picture(item)
            case _CameraPicture():
                self._segment.camera(item.camera, item.picture)
            case EncodedSound():
                self._segment.sound(item)
            case _Event():
                self._segment.event(item.event, item.at_s)

    def _begin(self, at_s: float, *, has_picture: bool) -> None:
        self._close()
        self._prune()
        self._check_room()
        self._segment = Segment(
            self._shelf,
            origin_s=at_s,
            zero_ns=self._zero_ns,
            codec=self._format.codec,
            size=self._format.size if has_picture else None,
            has_sound=self._format.has_sound,
            sound_channels=self._format.sound_channels,
            cameras=self._format.cameras,
        )
        for event in self._lasting.values():
            self._segment.event(event, at_s)
        self._logged = None

    def _resume(self, resume: _Resume) -> None:
        """Begin anew where something is missing: the pictures after it need a keyframe."""
        now_s = self._clock.now_s()
        missing = Missed(missed_s=round(now_s - resume.since_s, 3))
        _LOG.warning("the disk is too slow for the tape", missing_s=missing.missed_s)
        if self._segment is not None:
            self._segment.event(missing, now_s)
        self._end()

    def _look_after(self) -> None:
        """Do what is due now and then."""
        now_s = self._clock.now_s()
        if self._segment is not None and now_s >= self._sync_due_s:
            self._flushed_s = now_s
            self._segment.sync()
            took_s = self._clock.now_s() - now_s
            self._sync_due_s = now_s + max(SYNC_S, took_s / _SYNC_SHARE)
        elif self._segment is not None and now_s - self._flushed_s >= FLUSH_S:
            self._flushed_s = now_s
            self._segment.flush()
        if now_s - self._measured_s >= _ROOM_S:
            self._check_room()
        if now_s - self._pruned_s >= _PRUNE_S:
            self._prune()

    def _check_room(self) -> None:
        """Raise `TapeError` when the disk is nearly full: others write there, too."""
        self._measured_s = self._clock.now_s()
        free_bytes = shutil.disk_usage(self._shelf.folder).free
        if free_bytes < self._settings.min_free_gb * _GB:
            raise TapeError(DISK_FULL)

    def _prune(self) -> None:
        """Delete what has had its time; raises `TapeError` if there is no room even so."""
        self._pruned_s = self._clock.now_s()
        open_name = None if self._segment is None else self._segment.name
        most_bytes = self._settings.max_gb * _GB
        parts = self._shelf.parts()
        verdict = retain(
            [one.as_part(open_name) for one in parts],
            now_s=self._clock.wall_ms() / 1000,
            max_bytes=most_bytes,
            keep_days=self._settings.keep_days,
        )
        for name in verdict.gone:
            self._shelf.delete(name)
        self._shelved = (len(parts) - len(verdict.gone), verdict.left_bytes)
        if verdict.left_bytes > most_bytes and open_name is None:
            raise TapeError(TAPE_FULL)

    def _mark(self, keep: _Keep) -> None:
        # Files have the machine's own time, which may have been set since the server began.
        since_wall_s = self._clock.wall_ms() / 1000 - (self._clock.now_s() - keep.since_s)
        for part in self._shelf.parts():
            if part.ended_s >= since_wall_s:
                self._shelf.keep(part.name, keep.by)

    def _close(self) -> None:
        segment, self._segment = self._segment, None
        if segment is not None:
            segment.close()

    def _end(self) -> None:
        """Close the part, whatever happens; the next begins as soon as it can."""
        self._plan.ended()
        try:
            self._close()
        except WRITE_ERRORS as error:
            self._fails(_why(error))

    def _fails(self, why: Sentence) -> None:
        self._trouble = why
        if why != self._logged:
            self._logged = why
            _LOG.warning("nothing is recorded", folder=str(self._shelf.folder), why=str(why))

    def _leave_out(self, for_s: float) -> None:
        """Take what comes and leave it out, until the end or until it is time to try again."""
        end_s = self._clock.now_s() + for_s
        while (left_s := end_s - self._clock.now_s()) > 0 and not self._is_over:
            try:
                item = self._queue.get(timeout=min(left_s, _WAIT_S))
            except Empty:
                continue
            match item:
                case None:
                    self._is_over = True
                case _Keep():
                    with suppress(OSError, StateError):
                        self._mark(item)
                case _Forget():
                    self._lasting.pop(item.lasts_as, None)
                case _Event() if item.lasts_as is not None:
                    self._lasting[item.lasts_as] = item.event
                    self._not_written += 1
                case EncodedPicture() | _CameraPicture() | EncodedSound() | _Event():
                    self._not_written += 1


def _why(error: Exception) -> Sentence:
    if isinstance(error, WaxError):
        return error.sentence
    return says(reason_of(error))
