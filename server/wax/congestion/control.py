"""The interface between a peer and its congestion control."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, Protocol

from wax.congestion.delivery import Train

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.delivery import Delivery

Kind = Literal["audio", "video"]

_PAYLOAD_BYTES: Final = 1200
"""Fits any tunnel with all headers (WireGuard over IPv6: 1280)."""


class CongestionControl(Protocol):
    """Controls everything that one browser is sent; never raises. `now_s` never falls by much."""

    @property
    def uses_feedback(self) -> bool:
        """Whether it uses transport-wide feedback."""
        ...

    def negotiated(self, *, has_feedback: bool, kind: Kind = "video") -> None:
        """Handle whether this stream has transport-wide feedback."""
        ...

    def sent(
        self, size_bytes: int, now_s: float, *, is_media: bool, has_feedback: bool = True
    ) -> None:
        """Count a datagram that has left; `size_bytes` includes all headers.

        `has_feedback`: its stream has feedback, whether or not this packet requests it.
        """
        ...

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None:
        """Handle feedback about packets."""
        ...

    def lost(self, share: float, now_s: float, kind: Kind = "video") -> None:
        """Handle the share of a stream's packets that was lost lately, from 0 to 1."""
        ...

    def round_trip(self, round_trip_s: float, now_s: float) -> None:
        """Handle a measured round trip."""
        ...

    def requests_feedback(self, train: int | None, now_s: float) -> bool:
        """Return whether to request feedback for this packet; `train` is None for sound."""
        ...

    def free_in_s(self, unreported_s: float | None, now_s: float) -> float:
        """Return how long a picture has to wait; 0 if it may leave now.

        `unreported_s` is the age of the oldest packet whose feedback is missing, or None.
        """
        ...

    def plan_train(self, size_bytes: int, now_s: float) -> Train:
        """Return how to send the packets of a picture of this size."""
        ...

    @property
    def payload_bytes(self) -> int:
        """The largest payload of a packet that delays the sound behind it little enough."""
        ...

    def may_retransmit(self, size_bytes: int, age_s: float, now_s: float) -> bool:
        """Return whether to retransmit a lost packet that was first sent `age_s` ago."""
        ...


class NoCongestionControl:
    """Sends everything at once, in packets of ordinary size."""

    uses_feedback = False
    payload_bytes = _PAYLOAD_BYTES

    def negotiated(self, *, has_feedback: bool, kind: Kind = "video") -> None: ...

    def lost(self, share: float, now_s: float, kind: Kind = "video") -> None: ...

    def sent(
        self, size_bytes: int, now_s: float, *, is_media: bool, has_feedback: bool = True
    ) -> None: ...

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None: ...

    def round_trip(self, round_trip_s: float, now_s: float) -> None: ...

    def requests_feedback(self, train: int | None, now_s: float) -> bool:  # noqa: ARG002  # all or none
        return self.uses_feedback

    def free_in_s(self, unreported_s: float | None, now_s: float) -> float:  # noqa: ARG002  # never full
        return 0.0

    def plan_train(self, size_bytes: int, now_s: float) -> Train:  # noqa: ARG002  # all are alike
        return Train(number=0, pace_bps=float("inf"), payload_bytes=_PAYLOAD_BYTES)

    def may_retransmit(self, size_bytes: int, age_s: float, now_s: float) -> bool:  # noqa: ARG002  # all
        return True
