"""What the sender and the estimator of one viewer's link exchange."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

LinkState = Literal["starting", "steady", "congested", "blind"]

UDP_IP_BYTES: Final = 28
"""IPv4 and UDP headers; every datagram costs them (RFC 791, RFC 768)."""


@dataclass(frozen=True, slots=True)
class Delivery:
    """One packet's fate, as reported by the browser (transport-wide feedback).

    `sent_s` is on the server's clock. `arrived_s` is on the browser's clock, which has an unknown
    origin and drifts; None if the packet was lost. `size_bytes` is the whole datagram. `train` is
    the number of the packet's picture, None for sound and retransmissions.
    """

    sent_s: float
    arrived_s: float | None
    size_bytes: int
    kind: Literal["audio", "video", "repeat"]
    train: int | None = None


@dataclass(frozen=True, slots=True)
class Train:
    """How to send one picture: its packets paced at `pace_bps`, with at most `payload_bytes` each.

    A picture paced faster than the estimated rate probes the link.
    """

    number: int
    pace_bps: float
    payload_bytes: int


@dataclass(frozen=True, slots=True)
class LinkEstimate:
    """The state of the link to one browser."""

    state: LinkState
    rate_bps: float
    """The highest rate shown to get through, headers included."""
    used_bps: float
    """The rate of the last second."""
    queue_ms: float
    """The queuing delay now."""
    jitter_ms: float
    """The delay variation of the sound (99th percentile)."""
    lost: float
    """The share of packets lost lately, of the sound if it is sent."""
    burst: int
    """The number lost in a row (95th percentile), of the sound if it is sent."""
    round_trip_ms: float | None
    assumed: bool = False
    """No picture has come through yet, so the rate is a guess."""
    limit: Literal["link", "upload"] = "link"
    """What limits the rate: the link, or what the robot has left to send over it."""
