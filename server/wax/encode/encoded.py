"""An encoder's output: bytes with the properties that a lane needs."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

VIDEO_RATE_HZ = 90_000
"""RTP clock of every video codec (RFC 3551, section 5)."""

VIDEO_TIME_BASE = Fraction(1, VIDEO_RATE_HZ)


@dataclass(frozen=True, slots=True)
class EncodedPicture:
    """One encoded picture. `pts` is its capture time at 90 kHz on the server's clock.

    `layer` is the temporal layer: pictures depend only on pictures of the same or a lower layer,
    `sync` ones only on layer 0, and nothing depends on `droppable` ones.
    """

    data: bytes
    pts: int
    rendition: str
    keyframe: bool
    layer: int
    captured_s: float
    sync: bool = False
    droppable: bool = False


@dataclass(frozen=True, slots=True)
class EncodedSound:
    """One packet of sound. `pts` counts samples: 48 kHz for Opus, 8 kHz for PCMU."""

    data: bytes
    pts: int
    captured_s: float
    duration_samples: int


@dataclass(frozen=True, slots=True)
class SoundUnit:
    """An audio media unit of the thesis: sound captured as one piece, ready to leave as a burst.

    `packets` fill the unit without gaps; `captured_s` is when the first sample was captured. Unit
    numbers rise by one.
    """

    number: int
    packets: tuple[EncodedSound, ...]
    captured_s: float
