"""How old picture and sound are when they arrive at a client of ours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from wax.protocol.messages import RtpClock

if TYPE_CHECKING:
    from wax.client import Client
    from wax.client.sdp import Kind

_UINT32: Final = 2**32


class Ages:
    """Learns from the server's messages which RTP time is which moment."""

    def __init__(self) -> None:
        self._clocks: dict[str, RtpClock] = {}

    def learn(self, message: dict[str, Any]) -> None:
        if message["type"] == "rtp_clock":
            self._clocks[message["kind"]] = RtpClock(**message)

    def age_ms(self, client: Client, kind: Kind) -> float | None:
        """Return the age of what arrived last, then; None before anything has."""
        clock, newest = self._clocks.get(kind), client.media.newest(kind)
        if clock is None or newest is None:
            return None
        ticks = (newest.rtp - clock.rtp_origin + _UINT32 // 2) % _UINT32 - _UINT32 // 2
        captured_ms = clock.origin_server_ms + ticks * 1000 / clock.rate_hz
        return newest.at_s * 1000 + client.clock.ahead_ms - captured_ms
