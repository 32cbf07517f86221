"""What a peer asks before it sends, and tells when it has: congestion control as it sees it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, Protocol

from wax.congestion.delivery import Train

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.delivery import Delivery

Kind = Literal["audio", "video"]

_PAYLOAD_BYTES: Final = 1200
"""Fits any tunnel (WireGuard's IPv6 has 1280) with all headers."""


class CongestionControl(Protocol):
    """Of all that goes to one browser. Nothing here raises; `now_s` never falls by much."""

    @property
    def uses_feedback(self) -> bool:
        """Whether the browser shall tell when each packet has arrived."""
        ...

    def negotiated(self, *, has_feedback: bool, kind: Kind = "video") -> None:
        """Learn whether the browser tells when each packet of this stream has arrived."""
        ...

    def sent(
        self, size_bytes: int, now_s: float, *, is_media: bool, has_feedback: bool = True
    ) -> None:
        """Learn that a datagram of this size, headers and all, has left.

        `has_feedback` is one of a stream whose packets the browser tells of, be it marked or not.
        """
        ...

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None:
        """Learn what became of packets."""
        ...

    def lost(self, share: float, now_s: float, kind: Kind = "video") -> None:
        """Learn which share of a stream's packets did not arrive lately, from 0 to 1."""
        ...

    def round_trip(self, round_trip_s: float, now_s: float) -> None:
        """Learn how long the way there and back took just now."""
        ...

    def requests_feedback(self, train: int | None, now_s: float) -> bool:
        """Tell whether the browser shall say when this packet of a picture, or of sound, came."""
        ...

    def free_in_s(self, unreported_s: float | None, now_s: float) -> float:
        """Return how long a picture has to wait; 0 lets one go.

        `unreported_s` is the age of the oldest packet of which should have been heard, or None.
        """
        ...

    def plan_train(self, size_bytes: int, now_s: float) -> Train:
        """Return how the packets of a picture of this size shall leave."""
        ...

    def may_retransmit(self, size_bytes: int, age_s: float, now_s: float) -> bool:
        """Tell whether to send a lost packet again that was first sent `age_s` ago."""
        ...


class NoCongestionControl:
    """None: everything goes at once, in packets of ordinary size."""

    uses_feedback = False

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
