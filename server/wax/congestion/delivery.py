"""The values between the sender and the estimator of one viewer's link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

LinkState = Literal["starting", "steady", "congested", "blind"]

UDP_IP_BYTES: Final = 28
"""IPv4 and UDP headers; every datagram costs them (RFC 791, RFC 768)."""


@dataclass(frozen=True, slots=True)
class Delivery:
    """What became of one packet, as the browser told (transport-wide feedback).

    `sent_s` is on the server's clock. `arrived_s` is on the browser's own, whose origin is
    unknown and which drifts; None where the packet was lost. `size_bytes` is the whole datagram.
    `train` is the number of the picture that it belongs to, None for sound and repeats.
    """

    sent_s: float
    arrived_s: float | None
    size_bytes: int
    kind: Literal["audio", "video", "repeat"]
    train: int | None = None


@dataclass(frozen=True, slots=True)
class Train:
    """How one picture's packets shall leave: spread at `pace_bps`, none larger than told.

    A picture that is paced faster than the link is known to be is what probes it.
    """

    number: int
    pace_bps: float
    payload_bytes: int


@dataclass(frozen=True, slots=True)
class LinkEstimate:
    """What is known of the way to one browser.

    `rate_bps` is what it can carry, headers and all, as far as that was ever seen; `used_bps` what
    was sent in the last second. `queue_ms` is how long a packet waits in the way now, beyond the
    least that was seen; `jitter_ms` how much single packets of sound differ (99 of 100 are within).
    `lost` is the share of packets lost lately, and `burst` how many in a row at most (95 %), of
    sound where there is any. `assumed` while no picture came through, so that the rate is a guess.
    """

    state: LinkState
    rate_bps: float
    used_bps: float
    queue_ms: float
    jitter_ms: float
    lost: float
    burst: int
    round_trip_ms: float | None
    assumed: bool = False
