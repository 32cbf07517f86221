"""Finds the media units that have arrived completely, for `Hello.acknowledge`."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.client.rtp_header import RtpHeader
    from wax.client.sdp import Kind

_UINT32: Final = 2**32
_REMEMBERED: Final = 256
"""Packets of sound kept until it is known which of them end a unit."""


class Receipts:
    """A picture ends with the marker (RFC 3550, 5.1), a unit of sound where the server says."""

    def __init__(self) -> None:
        self._units: tuple[int, int] | None = None
        self._early: deque[int] = deque(maxlen=_REMEMBERED)

    def ends_unit(self, kind: Kind, packet: RtpHeader) -> bool:
        """Return whether this packet is known to be the last of its media unit."""
        if kind == "video":
            return packet.marker
        if self._units is None:
            self._early.append(packet.timestamp)
            return False
        return _is_last(packet.timestamp, *self._units)

    def learn(self, last_rtp: int, length: int) -> list[int]:
        """Set which packets end a unit of sound; return those that have already arrived."""
        self._units = (last_rtp, length)
        early = [rtp for rtp in self._early if _is_last(rtp, last_rtp, length)]
        self._early.clear()
        return early


def _is_last(rtp: int, last_rtp: int, length: int) -> bool:
    apart = (rtp - last_rtp) % _UINT32
    # Timestamps wrap, so a packet before the named one is almost a whole cycle after it.
    return (apart if apart < _UINT32 // 2 else _UINT32 - apart) % length == 0
