"""The fan-out of the sound: blocks in, one Opus encoder per media unit, packets to the lanes."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from math import ceil
from typing import TYPE_CHECKING, Final

from wax.media.lane import SoundLane
from wax.media.sound_encoder import SoundEncoder

if TYPE_CHECKING:
    from wax.config import AudioSettings
    from wax.media.encoded import EncodedSound
    from wax.media.source import Sound

_BLOCK_MS: Final = 20
_PAST_BLOCKS: Final = 27
"""540 ms of the past are kept for the pre-roll: the longest delay of sound that can be set, 500,
in whole media units of 20, 40 or 60."""


class _Unit:
    """One media-unit length: its encoder, and the packets that a pre-roll can be made of."""

    def __init__(self, *, bitrate_bps: int, mu_ms: int) -> None:
        self._encoder = SoundEncoder(bitrate_bps=bitrate_bps, mu_ms=mu_ms)
        self.past: deque[EncodedSound] = deque(maxlen=_PAST_BLOCKS * _BLOCK_MS // mu_ms)

    def encode(self, block: Sound) -> EncodedSound | None:
        sound = self._encoder.encode(block)
        if sound is not None:
            self.past.append(sound)
        return sound


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
                sound = unit.encode(block)
                if sound is not None:
                    self._encoded += 1
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
        75 ms a second at which a browser stretches sound. It is whole media units. The first
        listener of a length has as much of the past encoded as he needs; whoever follows within
        half a second and asks for more gets what there is.
        """
        if mu_ms == lane.mu_ms:
            return
        began = lane.mu_ms is None
        lane.choose(mu_ms)
        if mu_ms is not None:
            units = ceil(preroll_ms / mu_ms) if began else 0
            with self._lock:
                past = self._last(mu_ms, units)
            lane.put_all(past)
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

    def _last(self, mu_ms: int, units: int) -> list[EncodedSound]:
        """Return the last packets of this length, which is encoded from now on."""
        unit = self._units.get(mu_ms)
        if unit is None:
            unit = _Unit(bitrate_bps=self._settings.bitrate_bps, mu_ms=mu_ms)
            self._units[mu_ms] = unit
            blocks_per_unit = mu_ms // _BLOCK_MS
            available = len(self._past) // blocks_per_unit
            blocks = min(units, available) * blocks_per_unit
            for block in list(self._past)[len(self._past) - blocks :]:
                unit.encode(block)
        past = list(unit.past)
        return past[max(len(past) - units, 0) :]

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
