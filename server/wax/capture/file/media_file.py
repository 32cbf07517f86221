"""A media file or stream address as a video and an audio source in sync, from one demuxer."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.channels import with_channels
from wax.capture.file.address import is_network
from wax.capture.file.back_off import BackOff
from wax.capture.file.demuxer import Demuxer
from wax.capture.file.stream_decoder import StreamDecoder
from wax.capture.letterbox import black, fit_frame
from wax.capture.resample import Resampler
from wax.capture.source import BLOCK_SAMPLES, REST_S, SAMPLE_RATE_HZ, Picture, Sound

if TYPE_CHECKING:
    from collections.abc import Callable

    from av.audio.frame import AudioFrame
    from av.video.frame import VideoFrame
    from numpy.typing import NDArray

    from wax.capture.file.address import Kind, Track, Transport
    from wax.capture.file.demuxer import Coded
    from wax.clock import Clock
    from wax.config.audio import AudioSettings
    from wax.config.video import VideoSettings
    from wax.errors import SourceError


_PAUSE_S: Final = 0.25
"""In longer gaps in the file the last picture is repeated and silence is played."""

_LATE_S: Final = 0.1
"""Pictures and sound that are later than this are skipped."""

_CATCH_UP_S: Final = 0.5
"""After trying to catch up for this long, a late picture is shown and the next is a keyframe."""

_GAPLESS_S: Final = 0.002
_LIVE_LATE_S: Final = 0.5
_AHEAD_S: Final = 0.1
"""Sound is decoded this far ahead, so that the end of a pass is known before it plays."""


class MediaFile:
    """The file or address, with a video and an audio source, each decoded only if used.

    Both sources may be opened and closed at any time, each from its own thread; while both are open
    they share a demuxer and a timeline.
    """

    def __init__(
        self,
        address: str,
        clock: Clock,
        *,
        transport: Transport = "auto",
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._address = address
        self._transport = transport
        self._back_off = BackOff()
        self._failure: SourceError | None = None
        self.clock = clock
        self.sleep = sleep
        self._lock = threading.Lock()
        self._wanted: set[Kind] = set()
        self._demuxer: Demuxer | None = None
        self._users: list[Demuxer] = []

    def video(self, settings: VideoSettings) -> FileVideo:
        """Make the video source; call it before opening anything."""
        self._wanted.add("video")
        size = (settings.width, settings.height)
        return FileVideo(size, self)

    def audio(self, settings: AudioSettings) -> FileAudio:
        """Make the audio source; call it before opening anything."""
        self._wanted.add("audio")
        return FileAudio(settings.channels, self)

    def acquire_demuxer(self) -> Demuxer:
        """Return the running demuxer, or a new one if none works; raises `SourceError`.

        Until the address may be opened again, that is the error of the last attempt.
        """
        with self._lock:
            if self._demuxer is None or self._demuxer.failed:
                self._note_failure(self._demuxer)
                if self._failure is not None and self.clock.now_s() < self._back_off.until_s:
                    raise self._failure
                self._failure = None
                self._demuxer = Demuxer(
                    self._address, self.clock, frozenset(self._wanted), self._transport
                )
                self._demuxer.start()
            self._users.append(self._demuxer)
            return self._demuxer

    def release_demuxer(self, demuxer: Demuxer) -> None:
        """Release a demuxer; the last release stops it."""
        with self._lock:
            self._users.remove(demuxer)
            unused = demuxer not in self._users
            if self._demuxer is demuxer and (unused or demuxer.failed):
                self._note_failure(demuxer)
                self._demuxer = None
        if unused:
            demuxer.stop()

    def _note_failure(self, demuxer: Demuxer | None) -> None:
        """Record why the demuxer of a network address failed; call with the lock held."""
        if demuxer is not None and demuxer.failure is not None and is_network(self._address):
            self._failure = demuxer.failure
            self._back_off.failed(
                self.clock.now_s(), delivered=demuxer.delivered, refused=demuxer.refused
            )


class FileVideo(StreamDecoder):
    """The file's pictures, scaled to the configured size.

    `captured_s` is when a picture is due on the file's timeline; `wax.capture.file.demuxer` sets
    its error bound. In a long gap the last picture is repeated; a machine that is too slow skips
    late pictures. During a rest the demuxer goes on receiving, so that no camera's connection
    stalls; afterwards only what follows the newest keyframe is decoded.
    """

    kind: Kind = "video"
    rest_s: Final = REST_S

    def __init__(self, size: tuple[int, int], file: MediaFile) -> None:
        super().__init__(file)
        self._width, self._height = size
        self._frames: deque[tuple[VideoFrame, Coded]] = deque()
        self._shown: NDArray[np.uint8] | None = None
        self._within_s: float | None = None

    def close(self) -> None:
        super().close()
        self._frames.clear()
        self._shown = None

    def catch_up(self) -> None:
        if self.demuxer.skip_to_newest_keyframe(self.kind):
            self._frames.clear()
            self.flush()

    def read(self) -> Picture:
        return self._read_newest() if self.demuxer.live else self._read_due()

    def _read_newest(self) -> Picture:
        """Decode everything that has arrived and return the last picture, to avoid a backlog."""
        while not self._frames or self.demuxer.waiting(self.kind):
            self._frames.extend(self.decode_next(float("inf")) or ())
        frame, item = self._frames.pop()
        self._frames.clear()
        return self._show(frame, item, min(_due_s(frame, item), self.clock.now_s()))

    def _read_due(self) -> Picture:
        """Wait until the next picture is due."""
        began_s = self.clock.now_s()
        while True:
            now_s = self.clock.now_s()
            pause_s = now_s + _PAUSE_S
            while not self._frames:
                more = self.decode_next(pause_s)
                if more is None:
                    return self._repeat(pause_s)
                self._frames.extend(more)
            frame, item = self._frames[0]
            due_s = _due_s(frame, item)
            if due_s > pause_s:
                return self._repeat(pause_s)
            self._frames.popleft()
            late = now_s - due_s > _LATE_S
            if late and now_s - began_s < _CATCH_UP_S:
                continue
            if late:
                self._frames.clear()
                item.track.decoder.flush_buffers()
                self.demuxer.skip_to_keyframe(self.kind, now_s)
            return self._show(frame, item, due_s)

    def _show(self, frame: VideoFrame, item: Coded, due_s: float) -> Picture:
        self._within_s = item.within_s
        self._shown = fit_frame(
            frame, self._width, self._height, pixel_aspect=item.track.pixel_aspect
        )
        self.wait_until(due_s)
        return Picture(self._shown, due_s, item.within_s)

    def _repeat(self, until_s: float) -> Picture:
        self.wait_until(until_s)
        if self._shown is None:
            self._shown = black(self._width, self._height)
        return Picture(self._shown, self.clock.now_s(), self._within_s)


class FileAudio(StreamDecoder):
    """The file's sound in pieces of at most 10 ms, delivered when the last sample is due.

    A paced file's sound has no gaps: missing sound is replaced by silence. There are at most
    `channels`: one for a mono track, two for any other.
    """

    kind: Kind = "audio"

    def __init__(self, channels: int, file: MediaFile) -> None:
        super().__init__(file)
        self._channels = channels
        self._silence = np.zeros(BLOCK_SAMPLES, np.int16)
        self._resampler: tuple[Track, Resampler] | None = None
        self._pieces: deque[tuple[NDArray[np.int16], float]] = deque()
        self._end_s: float | None = None

    def close(self) -> None:
        super().close()
        self._resampler = None
        self._pieces.clear()
        self._end_s = None

    def read(self) -> Sound:
        return self._read_newest() if self.demuxer.live else self._read_due()

    def _read_newest(self) -> Sound:
        while True:
            while not self._pieces:
                self._extend(self.decode_next(float("inf")) or [])
            samples, due_s = self._pieces.popleft()
            heard_s = self.clock.now_s() - len(samples) / SAMPLE_RATE_HZ
            if heard_s - due_s < _LIVE_LATE_S:
                return Sound(samples=samples, captured_s=min(due_s, heard_s))

    def _read_due(self) -> Sound:
        while True:
            now_s = self.clock.now_s()
            piece = self._peek(now_s + _PAUSE_S)
            if self._end_s is None:
                self._end_s = piece[1] if piece is not None else now_s
            gap_s = piece[1] - self._end_s if piece is not None else _PAUSE_S
            if gap_s > _GAPLESS_S:
                samples = self._silence[: round(gap_s * SAMPLE_RATE_HZ)]
            else:
                samples, _ = self._pieces.popleft()
                if gap_s < -_GAPLESS_S:
                    samples = samples[round(-gap_s * SAMPLE_RATE_HZ) :]
            captured_s = self._end_s
            self._end_s += len(samples) / SAMPLE_RATE_HZ
            if now_s - self._end_s > _LATE_S:
                self._end_s = None
            elif len(samples):
                self.wait_until(self._end_s)
                return Sound(samples=samples, captured_s=captured_s)

    def _peek(self, until_s: float) -> tuple[NDArray[np.int16], float] | None:
        """Return the next piece without consuming it; None if none is due before `until_s`."""
        while not self._pieces or self._pieces[-1][1] - self._pieces[0][1] < _AHEAD_S:
            more = self.decode_next(until_s)
            if more is None:
                break
            self._extend(more)
        return self._pieces[0] if self._pieces and self._pieces[0][1] < until_s else None

    def _extend(self, frames: list[tuple[AudioFrame, Coded]]) -> None:
        begins = False
        for frame, item in frames:
            if self._resampler is None or self._resampler[0] is not item.track:
                channels = min(self._channels, frame.layout.nb_channels)
                self._resampler = (item.track, Resampler(channels))
                self._silence = with_channels(np.zeros(BLOCK_SAMPLES, np.int16), channels)
                begins = True
            for samples, time_s in self._resampler[1].feed(frame):
                if begins:
                    self._end_before(item.zero_s + time_s)
                    begins = False
                for begin in range(0, len(samples), BLOCK_SAMPLES):
                    due_s = item.zero_s + time_s + begin / SAMPLE_RATE_HZ
                    self._pieces.append((samples[begin : begin + BLOCK_SAMPLES], due_s))

    def _end_before(self, moment_s: float) -> None:
        """Cut off the encoder's padding, which would overlap the next pass."""
        while self._pieces:
            samples, due_s = self._pieces.pop()
            kept = round((moment_s - due_s) * SAMPLE_RATE_HZ)
            if kept > 0:
                self._pieces.append((samples[:kept], due_s))
                return


def _due_s(frame: VideoFrame, item: Coded) -> float:
    return item.zero_s + float((frame.pts or 0) * item.packet.time_base)
