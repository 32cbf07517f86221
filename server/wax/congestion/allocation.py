"""The allocator's results: what one viewer is sent, and why."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.sentence import Sentence


@dataclass(frozen=True, slots=True)
class SoundEncoding:
    """How the sound is encoded: one audio media unit a packet (thesis 3.2), 1 or 2 channels."""

    mu_ms: int
    bitrate_bps: int
    channels: int = 1

    @property
    def name(self) -> str:
        stereo = ", stereo" if self.channels > 1 else ""
        return f"{self.mu_ms} ms at {self.bitrate_bps / 1000:g} kbit/s{stereo}"


@dataclass(frozen=True, slots=True)
class Step:
    """One step of the rendition ladder; `name` is the rendition's name in the hub."""

    name: str
    size: str
    fps: float
    bitrate_bps: int
    layers: int
    """Temporal layers that can be dropped from the top; each drop halves the picture rate."""


@dataclass(frozen=True, slots=True)
class Allocation:
    """What one viewer is sent from now on.

    Pictures above `top_layer` are dropped. `redundancy` is the number of earlier units that each
    packet of sound repeats (RFC 2198). `reason` tells the viewer why they get no more. `tries` is
    true while a picture that had been given up is on trial: nothing shows yet that the link carries
    it. `left_bps` is the rate with which other cameras may start; `kept_bps` is the rate that those
    already sent may keep.
    """

    step: Step | None
    top_layer: int
    sound: SoundEncoding | None
    redundancy: int
    reason: Sentence
    tries: bool = False
    left_bps: float = 0.0
    kept_bps: float = 0.0


@lru_cache(maxsize=64)
def area(size: str) -> int:
    """Return the pixels of a size as "640x480"; raises ValueError for any other text."""
    width, _, height = size.partition("x")
    if not (width.isascii() and width.isdecimal() and height.isascii() and height.isdecimal()):
        raise ValueError(f"{size} is no size; write it as 640x480")
    return int(width) * int(height)
