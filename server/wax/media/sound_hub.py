"""The fan-out of the sound: blocks in, one Opus encoder per media unit, packets to the lanes."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from typing import TYPE_CHECKING, Final

from wax.media.lane import SoundLane
from wax.media.sound_encoder import SoundEncoder

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config import AudioSettings
    from wax.media.encoded import EncodedSound
    from wax.media.source import Sound

_PAST_BLOCKS: Final = 25
"""500 ms of the past are kept for the pre-roll: the longest delay of sound that can be set."""


class _Unit:
    """One media-unit length: its encoder, and the packets of the last half second."""

    def __init__(self, encoder: SoundEncoder) -> None:
        self.encoder = encoder
        self.past: deque[EncodedSound] = deque(maxlen=_PAST_BLOCKS)


class SoundHub:
    """Encodes the sound once per media-unit length that somebody wants.

    `push` is called from the capture's thread, the rest from the event loop. Encoding 20 ms
    takes a fraction of a millisecond, so one lock holds it all together.
    """

    def __init__(self, *, settings: AudioSettings) -> None:
        self._settings = settings
        self._lock = threading.Lock()
        self._past: deque[Sound] = deque(maxlen=_PAST_BLOCKS)
        self._units: dict[int, _Unit] = {}
        self._lanes: set[SoundLane] = set()
        self._dropped_by_gone = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._captured = 0
        self._encoded = 0

    def start(self) -> None:
        self._loop = asyncio.get_running_loop()

    def push(self, block: Sound) -> None:
        """Take the next 20 ms from the microphone's thread."""
        with self._lock:
            self._captured += 1
            self._past.append(block)
            for mu_ms, unit in self._units.items():
                sound = unit.encoder.encode(block)
                if sound is not None:
                    self._encoded += 1
                    unit.past.append(sound)
                    self._from_thread(mu_ms, sound)

    def add(self) -> SoundLane:
        """Make a lane; nothing is sent to it until `choose`."""
        lane = SoundLane()
        self._lanes.add(lane)
        return lane

    def remove(self, lane: SoundLane) -> None:
        """Forget a lane; safe to call twice."""
        if lane in self._lanes:
            self._lanes.remove(lane)
            self._dropped_by_gone += lane.dropped
        self._forget_unwanted()

    def choose(self, lane: SoundLane, mu_ms: int | None, preroll_ms: float) -> None:
        """Send sound in media units of `mu_ms`, beginning `preroll_ms` in the past, or none.

        The pre-roll fills the browser's buffer to its delay at once, instead of by the
        75 ms a second at which a browser stretches sound.
        """
        if mu_ms == lane.mu_ms:
            return
        began = lane.mu_ms is None
        lane.choose(mu_ms, preroll_ms)
        if mu_ms is not None:
            with self._lock:
                past = self._ready(mu_ms)
            if began:
                lane.put_all(_last(past, preroll_ms))
        self._forget_unwanted()

    @property
    def wanted(self) -> list[int]:
        """The media units, in ms, that somebody hears now; no other is encoded."""
        return sorted(self._units)

    @property
    def dropped(self) -> int:
        """Packets that lanes had no room for since the start; never falls."""
        return self._dropped_by_gone + sum(lane.dropped for lane in self._lanes)

    def counts(self) -> dict[str, int]:
        """Count 20 ms blocks captured and packets encoded since the start."""
        return {"captured": self._captured, "encoded": self._encoded}

    def _ready(self, mu_ms: int) -> list[EncodedSound]:
        unit = self._units.get(mu_ms)
        if unit is None:
            unit = _Unit(SoundEncoder(bitrate_bps=self._settings.bitrate_bps, mu_ms=mu_ms))
            self._units[mu_ms] = unit
            for block in self._past:
                sound = unit.encoder.encode(block)
                if sound is not None:
                    unit.past.append(sound)
        return list(unit.past)

    def _forget_unwanted(self) -> None:
        wanted = {lane.mu_ms for lane in self._lanes}
        with self._lock:
            self._units = {mu: unit for mu, unit in self._units.items() if mu in wanted}

    def _from_thread(self, mu_ms: int, sound: EncodedSound) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._fan_out, mu_ms, sound)

    def _fan_out(self, mu_ms: int, sound: EncodedSound) -> None:
        for lane in self._lanes:
            if lane.mu_ms == mu_ms:
                lane.put_all((sound,))


def _last(past: Sequence[EncodedSound], preroll_ms: float) -> Sequence[EncodedSound]:
    """Return the packets that cover the last `preroll_ms`."""
    kept_ms = 0.0
    start = len(past)
    while start > 0 and kept_ms < preroll_ms:
        start -= 1
        kept_ms += past[start].duration_samples / 48
    return past[start:]
