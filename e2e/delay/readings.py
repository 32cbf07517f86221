"""What the instrument reads on one page: raw series in columns, nothing summed up yet.

All times are Unix milliseconds. Both ends of the link are on one machine, so the server's stamps
and the browser's readings use the same clock.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from pydantic import BaseModel, ConfigDict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.ear import Block


class _Columns(BaseModel):
    """Lists of one length; the elements with one index belong together."""

    model_config = ConfigDict(extra="forbid")


class Pictures(_Columns):
    """One row for each presented frame of the largest playing video."""

    at_ms: list[float] = []
    stamp_ms: list[float | None] = []
    """The test card's time in whole Unix ms; None where it cannot be read."""
    received_ms: list[float | None] = []
    """When its last packet had come, by the browser; None where it does not tell."""
    width: list[int] = []
    height: list[int] = []


class Sound(_Columns):
    """One row for each 10 ms of played sound."""

    start_ms: list[float] = []
    tone: list[float] = []
    """Amplitude of the test card's 300 Hz."""
    burst: list[float] = []
    """Amplitude of its 1 kHz, which begins at each whole second."""

    @classmethod
    def of(cls, heard: Sequence[Block]) -> Self:
        return cls(**{name: [getattr(one, name) for one in heard] for name in cls.model_fields})


class Counters(_Columns):
    """One row for each look at the browser's own counts (`getStats`), all since the start.

    None where this browser or page has no such count.
    """

    at_ms: list[float] = []
    played_samples: list[float | None] = []
    concealed_samples: list[float | None] = []
    concealment_events: list[float | None] = []
    stretched_samples: list[float | None] = []
    """Samples inserted where sound was played slowly, to wait for more."""
    sound_buffer_ms: list[float | None] = []
    """Mean jitter buffer delay since the previous look."""
    received_bytes: list[float | None] = []
    """All that the transport received: RTP, RTCP, data channels."""
    sent_bytes: list[float | None] = []


class PlayerSound(_Columns):
    """One row for each report of the page's built-in player, all since it began to play a peer."""

    at_ms: list[float] = []
    played_ms: list[float] = []
    concealed_ms: list[float] = []
    stretched_ms: list[float] = []


class Commands(_Columns):
    """One row for each answered ping over a data channel (WAX only)."""

    at_ms: list[float] = []
    round_trip_ms: list[float] = []


class SetPoints(_Columns):
    """One row for each set-point that the page handed to its data channel (WAX only)."""

    at_ms: list[float] = []


class Connections(_Columns):
    """One row for each change of state of any of the page's peer connections."""

    at_ms: list[float] = []
    state: list[str] = []


class Readings(BaseModel):
    """One page, from its opening to the last look."""

    model_config = ConfigDict(extra="forbid")

    opened_ms: float
    """When the navigation began."""
    first_picture_ms: float | None = None
    """When the first frame of any video was presented."""
    first_sound_ms: float | None = None
    pictures: Pictures = Pictures()
    sound: Sound = Sound()
    counters: Counters = Counters()
    player_sound: PlayerSound = PlayerSound()
    commands: Commands = Commands()
    set_points: SetPoints = SetPoints()
    connections: Connections = Connections()
