"""The fan-out of the sound: blocks in, one Opus encoder per encoding, packets to the lanes."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from functools import partial
from math import ceil, lcm
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import BLOCK_MS, BLOCK_SAMPLES, SAMPLE_RATE_HZ, Sound
from wax.encode.sample_clock import SampleClock
from wax.encode.sound_encoder import SoundEncoder
from wax.fanout.batches import in_batches
from wax.fanout.sound_lane import BoundedSoundLane

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.congestion.allocation import SoundEncoding
    from wax.encode.encoded import EncodedSound
    from wax.error_boundary import ErrorBoundary

_PAST_MS: Final = 720
"""How much past sound to keep: the longest pre-roll of 500 ms, rounded up to whole media units of
up to 120 ms, plus the current unit."""

_SILENCE: Final = np.zeros(BLOCK_SAMPLES, np.int16)

_WARM_MS: Final = 480
"""A new encoder begins with silence, and the speech codec needs this long until a listener coming
from another encoding decodes it well."""


class _Stream:
    """One encoding: its encoder, and recent packets for pre-rolls."""

    def __init__(self, encoding: SoundEncoding) -> None:
        self._encoder = SoundEncoder(encoding)
        self.unit_samples = self._encoder.unit_samples
        self.past: deque[EncodedSound] = deque(maxlen=_PAST_MS // encoding.mu_ms)

    def encode(self, block: Sound, pts: int) -> EncodedSound | None:
        sound = self._encoder.encode(block, pts)
        if sound is not None:
            self.past.append(sound)
        return sound


class SoundHub:
    """Encodes the sound once for each encoding in use.

    `push` and `skip` are called from the capture thread, the rest from the event loop. Encoding
    10 ms takes a fraction of a millisecond, so one lock covers everything. While `needed` is not
    set, nobody listens and the source may rest (`SourceThread`).
    """

    def __init__(self, clock: Clock) -> None:
        self.needed = threading.Event()
        self._now_s = clock.now_s
        self._needed_since_s = 0.0
        self._lock = threading.Lock()
        self._clock = SampleClock()
        self._past: deque[tuple[Sound, int]] = deque(maxlen=_PAST_MS // BLOCK_MS)
        self._streams: dict[SoundEncoding, _Stream] = {}
        self._lanes: dict[BoundedSoundLane, Callable[[SoundEncoding, EncodedSound], None]] = {}
        self._dropped_by_gone = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._captured = 0
        self._encoded = 0
        self.channels = 1
        """The channel count of the newest block."""

    def start(self) -> None:
        self._loop = asyncio.get_running_loop()

    def push(self, block: Sound) -> None:
        """Encode and deliver the next block; called in the microphone's thread."""
        with self._lock:
            self._captured += 1
            self.channels = block.channels
            if block.captured_s < self._needed_since_s:
                return
            pts = self._clock.stamp(block.captured_s)
            self._past.append((block, pts))
            for encoding, stream in self._streams.items():
                sound = stream.encode(block, pts)
                if sound is not None:
                    self._encoded += 1
                    self._from_thread(encoding, sound)

    def skip(self, sound: Sound) -> None:
        """Count a piece that nobody needs."""
        self._captured += 1
        self.channels = sound.channels

    def add(self, boundary: ErrorBoundary) -> BoundedSoundLane:
        """Make a lane, which is called inside `boundary`; it gets nothing until `choose`."""
        lane = BoundedSoundLane()
        self._lanes[lane] = boundary.around(lane.put)
        return lane

    def prioritise(self, lane: BoundedSoundLane) -> None:
        """Serve this lane first: the operator does not wait for a crowd."""
        if lane in self._lanes:
            self._lanes = {lane: self._lanes[lane], **self._lanes}

    def remove(self, lane: BoundedSoundLane) -> None:
        """Forget a lane; safe to call twice."""
        if lane in self._lanes:
            del self._lanes[lane]
            self._dropped_by_gone += lane.dropped
        self._forget_unwanted()

    def choose(
        self, lane: BoundedSoundLane, encoding: SoundEncoding | None, preroll_ms: float
    ) -> None:
        """Send this lane sound in this encoding, beginning `preroll_ms` in the past, or none.

        The pre-roll, in whole media units, fills the browser's buffer at once, instead of at the 75
        ms a second at which a browser stretches sound. The first listener of an encoding gets as
        much past sound as requested; one who joins within half a second gets what is available.
        Before the first listener of all there was silence.

        A listener who changes encodings gets no pre-roll: the new encoding starts at the next
        common unit boundary, at most 120 ms from now.
        """
        if encoding == lane.encoding:
            return
        old = lane.encodings[0] if lane.encodings else None
        if encoding is None:
            lane.choose(None)
        elif old is None:
            lane.choose(encoding)
            units = ceil(preroll_ms / encoding.mu_ms)
            with self._lock:
                stream = self._stream(encoding, units)
                past = list(stream.past)[-units:] if units else []
            for sound in past:
                lane.put(encoding, sound)
        else:
            with self._lock:
                self._stream(encoding, _WARM_MS // encoding.mu_ms)
                meet = lcm(old.mu_ms, encoding.mu_ms) * SAMPLE_RATE_HZ // 1000
                change_pts = -(-self._clock.next_pts // meet) * meet
            lane.choose(encoding, change_pts)
        self._forget_unwanted()

    @property
    def wanted(self) -> list[str]:
        """The encodings in use, the shortest first; no other is encoded."""
        encodings = sorted(self._streams, key=lambda one: (one.mu_ms, one.bitrate_bps))
        return [one.name for one in encodings]

    @property
    def dropped(self) -> int:
        """Packets dropped by full lanes since the start; never falls."""
        return self._dropped_by_gone + sum(lane.dropped for lane in self._lanes)

    def counts(self) -> dict[str, int]:
        """Count blocks captured and packets encoded since the start."""
        return {"captured": self._captured, "encoded": self._encoded}

    def _stream(self, encoding: SoundEncoding, units: int) -> _Stream:
        """Return this encoding's stream; a new one is primed with the last `units` units."""
        if not self._streams:
            self._begin()
        stream = self._streams.get(encoding)
        if stream is None:
            stream = self._streams[encoding] = _Stream(encoding)
            unit = stream.unit_samples
            begin_pts = (self._clock.next_pts // unit - units) * unit
            for block, pts in self._past:
                if pts >= begin_pts:
                    stream.encode(block, pts)
        return stream

    def _begin(self) -> None:
        """Continue after the last block with silence until now, and need sound from now on."""
        now_s = self._needed_since_s = self._now_s()
        known_s = self._past[-1][0].captured_s if self._past else float("-inf")
        for ago_ms in range(_PAST_MS, 0, -BLOCK_MS):
            captured_s = now_s - ago_ms / 1000
            if captured_s >= known_s + BLOCK_MS / 1000:
                self._past.append((Sound(_SILENCE, captured_s), self._clock.stamp(captured_s)))
        self.needed.set()

    def _forget_unwanted(self) -> None:
        wanted = {encoding for lane in self._lanes for encoding in lane.encodings}
        with self._lock:
            self._streams = {f: stream for f, stream in self._streams.items() if f in wanted}
            if not self._streams:
                self.needed.clear()

    def _from_thread(self, encoding: SoundEncoding, sound: EncodedSound) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._fan_out, encoding, sound)

    def _fan_out(self, encoding: SoundEncoding, sound: EncodedSound) -> None:
        takers = [put for lane, put in self._lanes.items() if encoding in lane.encodings]
        in_batches([partial(put, encoding, sound) for put in takers])
        if not takers:
            self._forget_unwanted()
