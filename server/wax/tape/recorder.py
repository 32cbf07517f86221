"""Writes the tape in a thread of its own, so that nobody waits for the disk.

Items to write are queued. A full queue means that the disk is too slow: then everything is dropped
until the queue is empty, a new part begins, and the gap is recorded.

A killed server loses what arrived after the last flush (every `FLUSH_S`), a power cut what arrived
after the last sync (every `SYNC_S`). Each costs the disk some extra writes, whose number depends on
its file system. A slow memory card is synced less often, so that three quarters of the time are
left for writing.
"""

from __future__ import annotations

import shutil
import threading
from collections import deque
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
    from wax.tape.retention import Keeper
    from wax.tape.segment_plan import Kind
    from wax.tape.shelf import Shelf
    from wax.tape.tape_file import Codec

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
    """Nothing can be recorded now, for the reason given."""


@dataclass(frozen=True, slots=True)
class Format:
    """The format of picture and sound; `size` is None without a camera.

    `sound_channels` is the most that a packet of sound may have. `cameras` are all cameras but the
    driving view.
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
class _Disown:
    begin_s: float
    end_s: float


@dataclass(frozen=True, slots=True)
class _Forget:
    """Stops repeating the event under this key."""

    lasts_as: Hashable


@dataclass(frozen=True, slots=True)
class _Resume:
    """Marks the end of a gap that began at this time."""

    since_s: float


_Recorded = EncodedPicture | _CameraPicture | EncodedSound | _Event
_Item = _Recorded | _Keep | _Disown | _Forget | _Resume


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    """The state of recording; `parts` and `parts_bytes` are from the last scan of the folder.

    `waiting` counts the items that are not written yet, `left_out` those that were dropped because
    the disk was too slow or failed: pictures, packets of sound and events.
    """

    problem: Sentence | None
    parts: int
    parts_bytes: int
    waiting: int
    left_out: int


class Recorder:
    """Call its methods from the event loop after `start`; none of them blocks or raises."""

    def __init__(
        self,
        shelf: Shelf,
        *,
        settings: RecordingSettings,
        format: Format,  # noqa: A002  # the plain word
        clock: Clock,
    ) -> None:
        self._shelf = shelf
        self._settings = settings
        self._format = format
        self._clock = clock
        # The offset never changes, so that times of events do not jump with the machine's clock.
        self._zero_ns = clock.wall_ms() * 1_000_000 - round(clock.now_s() * 1e9)
        self._queue: SimpleQueue[_Item | None] = SimpleQueue()
        self._behind_since_s: float | None = None
        self._gave_up: Sentence | None = None
        self._dropped = 0
        self._thread = threading.Thread(target=self._run, name="tape", daemon=True)
        # Only the thread writes the attributes below.
        self._trouble: Sentence | None = None
        self._unwritten = 0
        self._shelved = (0, 0)
        self._is_over = False
        self._segment: Segment | None = None
        self._plan = SegmentPlan(
            segment_s=settings.segment_s,
            keyframe_interval_s=format.keyframe_interval_s,
            has_camera=format.size is not None,
        )
        self._lasting: dict[Hashable, TapeEvent] = {}
        self._marks: deque[_Keep | _Disown] = deque()
        self._flushed_s = self._pruned_s = self._measured_s = float("-inf")
        self._sync_due_s = float("-inf")
        self._logged: Sentence | None = None

    def start(self) -> None:
        self._thread.start()

    def request_stop(self) -> None:
        self._queue.put(None)

    def stop(self, within_s: float = 1.0) -> None:
        """Write what is queued and end; give up after `within_s`."""
        self.request_stop()
        if self._thread.is_alive():
            self._thread.join(within_s)

    def picture(self, picture: EncodedPicture) -> None:
        self._enqueue(picture)

    def camera(self, camera: int, picture: EncodedPicture) -> None:
        """Record a picture of a camera other than the driving view; these count from 1."""
        self._enqueue(_CameraPicture(camera, picture))

    def needs_keyframe(self, camera: int) -> bool:
        """Return whether the open part still lacks the keyframe that starts this camera's file."""
        segment = self._segment
        return segment is not None and not segment.has_camera(camera)

    def sound(self, sound: EncodedSound) -> None:
        self._enqueue(sound)

    def event(self, event: TapeEvent, at_s: float, lasts_as: Hashable = None) -> None:
        """Record an event; the newest of each `lasts_as` is repeated in each new part.

        This way each part can be read without the earlier ones.
        """
        self._enqueue(_Event(event, at_s, lasts_as))

    def forget(self, lasts_as: Hashable) -> None:
        """Stop repeating the event under this key in new parts."""
        self._queue.put(_Forget(lasts_as))

    def give_up(self, why: Sentence) -> None:
        """Stop recording until the server is restarted."""
        self._gave_up = why

    def keep(self, since_s: float, by: Keeper) -> None:
        """Mark all parts since then as kept."""
        self._queue.put(_Keep(since_s, by))

    def disown(self, begin_s: float, end_s: float) -> None:
        """Mark that nothing of this time is to be used."""
        self._queue.put(_Disown(begin_s, end_s))

    @property
    def problem(self) -> Sentence | None:
        """Why nothing is recorded now; None while recording works."""
        behind = None if self._behind_since_s is None else TOO_SLOW
        return self._gave_up or self._trouble or behind

    @property
    def waiting(self) -> int:
        """How many items are not written yet."""
        return self._queue.qsize()

    def status(self) -> RecorderStatus:
        parts, parts_bytes = self._shelved
        return RecorderStatus(
            problem=self.problem,
            parts=parts,
            parts_bytes=parts_bytes,
            waiting=self.waiting,
            left_out=self._dropped + self._unwritten,
        )

    def _enqueue(self, item: _Item) -> None:
        if self._behind_since_s is None and self.waiting >= MOST_WAITING:
            self._behind_since_s = self._clock.now_s()
        elif self._behind_since_s is not None and self.waiting == 0:
            self._queue.put(_Resume(self._behind_since_s))
            self._behind_since_s = None
        if self._behind_since_s is None and self._gave_up is None:
            self._queue.put(item)
        else:
            self._dropped += 1

    # --- the thread --------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._is_over:
            try:
                self._record()
            except (TapeError, StateError, *WRITE_ERRORS) as error:
                self._set_trouble(_why(error))
            except Exception:
                _LOG.exception("the tape failed")
                self._set_trouble(Sentence("tape.failed"))
            if not self._is_over:
                self._drop_items(RETRY_S)

    def _record(self) -> None:
        """Write items until stopped; raises when nothing can be written."""
        try:
            self._shelf.prepare()
            self._apply_marks()
            self._prune()
            self._check_room()
            self._trouble = None
            while not self._is_over:
                self._write_next()
                self._do_periodic_work()
        finally:
            self._end_part()

    def _write_next(self) -> None:
        """Write the next item, if one arrives soon."""
        try:
            item = self._queue.get(timeout=_WAIT_S)
        except Empty:
            return
        match item:
            case None:
                self._is_over = True
            case _Keep() | _Disown():
                self._marks.append(item)
                self._apply_marks()
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
            self._begin_part(at_s, has_picture=kind == "keyframe")
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

    def _begin_part(self, at_s: float, *, has_picture: bool) -> None:
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
        """Record the gap and end the part: the pictures after a gap need a keyframe."""
        now_s = self._clock.now_s()
        missing = Missed(missed_s=round(now_s - resume.since_s, 3))
        _LOG.warning("the disk is too slow for the tape", missing_s=missing.missed_s)
        if self._segment is not None:
            self._segment.event(missing, now_s)
        self._end_part()

    def _do_periodic_work(self) -> None:
        """Flush, sync, check the disk and prune, each when due."""
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
        """Raise `TapeError` when the disk, which other programs use, too, is nearly full."""
        self._measured_s = self._clock.now_s()
        free_bytes = shutil.disk_usage(self._shelf.folder).free
        if free_bytes < self._settings.min_free_gb * _GB:
            raise TapeError(DISK_FULL)

    def _prune(self) -> None:
        """Delete expired parts; raises `TapeError` if the tape is still too large."""
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

    def _mark_kept(self, keep: _Keep) -> None:
        # File times follow the machine's clock, which may have been set since the server started.
        since_wall_s = self._clock.wall_ms() / 1000 - (self._clock.now_s() - keep.since_s)
        for part in self._shelf.parts():
            if part.ended_s >= since_wall_s:
                self._shelf.keep(part.name, keep.by)

    def _apply_marks(self) -> None:
        """Apply the marks that wait; what fails waits until recording is tried again."""
        while self._marks:
            match self._marks[0]:
                case _Keep() as keep:
                    self._mark_kept(keep)
                case _Disown(begin_s, end_s):
                    zero_s = self._zero_ns / 1e9
                    self._shelf.disown(zero_s + begin_s, zero_s + end_s)
            self._marks.popleft()

    def _close(self) -> None:
        segment, self._segment = self._segment, None
        if segment is not None:
            segment.close()

    def _end_part(self) -> None:
        """Close the part, even if that fails; the next begins as soon as possible."""
        self._plan.ended()
        try:
            self._close()
        except WRITE_ERRORS as error:
            self._set_trouble(_why(error))

    def _set_trouble(self, why: Sentence) -> None:
        self._trouble = why
        if why != self._logged:
            self._logged = why
            _LOG.warning("nothing is recorded", folder=str(self._shelf.folder), why=str(why))

    def _drop_items(self, for_s: float) -> None:
        """Drop items for `for_s` or until stopped, but still apply marks and lasting events."""
        end_s = self._clock.now_s() + for_s
        while (left_s := end_s - self._clock.now_s()) > 0 and not self._is_over:
            try:
                item = self._queue.get(timeout=min(left_s, _WAIT_S))
            except Empty:
                continue
            match item:
                case None:
                    self._is_over = True
                case _Keep() | _Disown():
                    self._marks.append(item)
                    with suppress(OSError, StateError):
                        self._apply_marks()
                case _Forget():
                    self._lasting.pop(item.lasts_as, None)
                case _Event() if item.lasts_as is not None:
                    self._lasting[item.lasts_as] = item.event
                    self._unwritten += 1
                case EncodedPicture() | _CameraPicture() | EncodedSound() | _Event():
                    self._unwritten += 1


def _why(error: Exception) -> Sentence:
    if isinstance(error, WaxError):
        return error.sentence
    return says(reason_of(error))
