"""The values between the allocator and the lanes: what one viewer is sent, and why."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SoundForm:
    """How the sound is encoded: one audio media unit a packet (thesis 3.2)."""

    mu_ms: int
    bitrate_bps: int

    @property
    def name(self) -> str:
        return f"{self.mu_ms} ms at {self.bitrate_bps / 1000:g} kbit/s"


@dataclass(frozen=True, slots=True)
class Step:
    """One step of the rendition ladder; `name` is how the hub knows it."""

    name: str
    size: str
    fps: float
    bitrate_bps: int
    layers: int
    """Temporal layers that can be left out from the top, each halving the rate of pictures."""


@dataclass(frozen=True, slots=True)
class Allocation:
    """What one viewer is sent from now on.

    Pictures above `top_layer` are left out. `redundancy` is how many earlier units each packet of
    sound carries again (RFC 2198). `reason` says in plain words why it is not more.
    """

    step: Step | None
    top_layer: int
    sound: SoundForm | None
    redundancy: int
    reason: str
