"""The fan-out of the baseline's sound: it encodes blocks and passes whole units to all viewers."""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING, Final

from wax.baseline.mulaw_encoder import MuLawEncoder

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import Sound
    from wax.encode.encoded import SoundUnit
    from wax.error_boundary import ErrorBoundary

_BITRATE_BPS: Final = 64_000
"""PCMU (RFC 3551, 4.5.14)."""


class UnitHub:
    """Encodes the sound once, in media units of one length, and passes them to all listeners.

    `push` and `skip` are called from the capture thread, the rest from the event loop. While
    `needed` is not set, nobody listens and the source may rest (`SourceThread`).
    """

    def __init__(self, *, mu_ms: int) -> None:
        self.needed = threading.Event()
        self._mu_ms = mu_ms
        self._encoder = MuLawEncoder(mu_ms=mu_ms)
        self._takers: dict[Callable[[SoundUnit], None], Callable[[SoundUnit], None]] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._captured = 0
        self._encoded = 0
        self.channels = 1
        """The thesis's sound is mono (3.4.1)."""
        self.dropped = 0
        """Units that did not reach a listener, since the start."""

    def start(self) -> None:
        self._loop = asyncio.get_running_loop()

    def push(self, block: Sound) -> None:
        """Handle the next block, in the microphone's thread."""
        self._captured += 1
        unit = self._encoder.encode(block.with_channels(self.channels))
        if unit is None:
            return
        self._encoded += len(unit.packets)
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._fan_out, unit)

    def skip(self, _sound: Sound) -> None:
        """Count a piece that nobody needs."""
        self._captured += 1

    def listen(self, take: Callable[[SoundUnit], None], boundary: ErrorBoundary) -> None:
        """Call `take` inside `boundary` with every unit that is completed from now on."""
        self._takers[take] = boundary.around(take)
        self.needed.set()

    def leave(self, take: Callable[[SoundUnit], None]) -> None:
        """Remove a listener; safe to call twice."""
        self._takers.pop(take, None)
        if not self._takers:
            self.needed.clear()

    @property
    def unit_samples(self) -> int:
        """Length of a unit on the RTP clock; each begins at a whole multiple of it."""
        return self._encoder.unit_samples

    @property
    def wanted(self) -> list[str]:
        """The only encoding, while anybody listens."""
        return [f"{self._mu_ms} ms at {_BITRATE_BPS / 1000:g} kbit/s"] if self._takers else []

    def counts(self) -> dict[str, int]:
        """Count blocks captured and packets encoded since the start."""
        return {"captured": self._captured, "encoded": self._encoded}

    def _fan_out(self, unit: SoundUnit) -> None:
        for take in tuple(self._takers.values()):
            take(unit)
