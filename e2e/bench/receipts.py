"""Which media units have come whole, for servers that ask to be told: the `thesis` policy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from aiortc.rtp import RtpPacket

_UINT32: Final = 2**32
_MOST_REMEMBERED: Final = 256
"""Packets of sound that have come before it is known which of them end a unit."""


class Receipts:
    """A picture is whole with the packet that bears the marker (RFC 3550, 5.1), sound as told."""

    def __init__(self) -> None:
        self._units: tuple[int, int] | None = None
        self._early: list[int] = []

    def ends_unit(self, kind: Literal["audio", "video"], packet: RtpPacket) -> bool:
        """Say whether this packet is the last of its media unit; as far as that is known."""
        if kind == "video":
            return bool(packet.marker)
        if self._units is None:
            self._early = [*self._early, packet.timestamp][-_MOST_REMEMBERED:]
            return False
        return self._is_last(packet.timestamp, *self._units)

    def learn(self, last_rtp: int, length: int) -> list[int]:
        """Learn which packets end a unit of the sound; return those that have come before."""
        self._units = (last_rtp, length)
        early, self._early = self._early, []
        return [rtp for rtp in early if self._is_last(rtp, last_rtp, length)]

    @staticmethod
    def _is_last(rtp: int, last_rtp: int, length: int) -> bool:
        apart = (rtp - last_rtp) % _UINT32
        # A packet from before the one that was named lies almost a whole round after it.
        return (apart if apart < _UINT32 // 2 else _UINT32 - apart) % length == 0
