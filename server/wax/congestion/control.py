"""The interface between a peer and its congestion control, and what they exchange."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from wax.congestion.wire_cost import MAX_PAYLOAD_BYTES

if TYPE_CHECKING:
    from collections.abc import Sequence

Kind = Literal["audio", "video"]
LinkState = Literal["starting", "steady", "congested", "blind"]


@dataclass(frozen=True, slots=True)
class Delivery:
    """Whether and when one packet arrived, as the browser reports (transport-wide feedback).

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
    """How to send one picture: paced at `pace_bps`, with at most `payload_bytes` a packet."""

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
    """The rate sent over the last second."""
    queue_ms: float
    jitter_ms: float
    """The delay variation of the sound (99th percentile)."""
    lost: float
    """The share of packets lost lately, of the sound if it is sent."""
    burst: int
    """The number lost in a row (95th percentile), of the sound if it is sent."""
    round_trip_ms: float | None
    assumed: bool = False
    """No picture has come through yet, so the rate is a guess."""
    limit: Literal["link", "share"] = "link"
    """What limits the rate: the link, or this viewer's share of what the robot can send."""


class CongestionControl:
    """Controls everything that one browser is sent; never raises. `now_s` never falls by much.

    This base class controls nothing: everything is sent at once, in packets of ordinary size.
    """

    uses_feedback = False

    def negotiated(self, *, has_feedback: bool, kind: Kind = "video") -> None:
        """Handle whether this stream has transport-wide feedback."""

    def sent(
        self, size_bytes: int, now_s: float, *, is_media: bool, has_feedback: bool = True
    ) -> None:
        """Count a datagram that was sent; `size_bytes` includes all headers.

        `has_feedback` says that its stream has feedback, whether or not this packet requests it.
        """

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None:
        """Handle feedback about packets."""

    def lost(self, share: float, now_s: float, kind: Kind = "video") -> None:
        """Handle the share of a stream's packets that was lost lately, from 0 to 1."""

    def round_trip(self, round_trip_s: float, now_s: float) -> None:
        """Handle a measured round trip."""

    def requests_feedback(self, train: int | None, now_s: float) -> bool:  # noqa: ARG002
        """Return whether to request feedback for this packet; `train` is None for sound."""
        return self.uses_feedback

    def free_in_s(self, unreported_s: float | None, now_s: float) -> float:  # noqa: ARG002
        """Return how long a picture must wait; 0 if it may be sent now.

        `unreported_s` is the age of the oldest packet whose feedback is missing, or None.
        """
        return 0.0

    def plan_train(self, size_bytes: int, now_s: float) -> Train:  # noqa: ARG002
        """Return how to send the packets of a picture of this size."""
        return Train(number=0, pace_bps=float("inf"), payload_bytes=MAX_PAYLOAD_BYTES)

    @property
    def payload_bytes(self) -> int:
        """The largest payload whose packet does not delay the sound behind it too long."""
        return MAX_PAYLOAD_BYTES

    def may_retransmit(self, size_bytes: int, age_s: float, now_s: float) -> bool:  # noqa: ARG002
        """Return whether to retransmit a lost packet that was first sent `age_s` ago."""
        return True
