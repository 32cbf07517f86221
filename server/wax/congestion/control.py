"""The interface between a peer and its congestion control."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from wax.congestion.delivery import Train
from wax.congestion.wire_cost import MAX_PAYLOAD_BYTES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.delivery import Delivery

Kind = Literal["audio", "video"]


class CongestionControl:
    """Controls everything that one browser is sent; never raises. `now_s` never falls by much.

    By itself it controls nothing: everything leaves at once, in packets of ordinary size.
    """

    uses_feedback = False
    """Whether it uses transport-wide feedback."""

    def negotiated(self, *, has_feedback: bool, kind: Kind = "video") -> None:
        """Handle whether this stream has transport-wide feedback."""

    def sent(
        self, size_bytes: int, now_s: float, *, is_media: bool, has_feedback: bool = True
    ) -> None:
        """Count a datagram that has left; `size_bytes` includes all headers.

        `has_feedback`: its stream has feedback, whether or not this packet requests it.
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
        """Return how long a picture has to wait; 0 if it may leave now.

        `unreported_s` is the age of the oldest packet whose feedback is missing, or None.
        """
        return 0.0

    def plan_train(self, size_bytes: int, now_s: float) -> Train:  # noqa: ARG002
        """Return how to send the packets of a picture of this size."""
        return Train(number=0, pace_bps=float("inf"), payload_bytes=MAX_PAYLOAD_BYTES)

    @property
    def payload_bytes(self) -> int:
        """The largest payload of a packet that delays the sound behind it little enough."""
        return MAX_PAYLOAD_BYTES

    def may_retransmit(self, size_bytes: int, age_s: float, now_s: float) -> bool:  # noqa: ARG002
        """Return whether to retransmit a lost packet that was first sent `age_s` ago."""
        return True
