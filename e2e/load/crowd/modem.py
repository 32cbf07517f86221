"""One viewer's own line, usually a modem's: the link model between socket and ICE."""

from __future__ import annotations

import asyncio
import time
from functools import partial
from struct import Struct
from typing import TYPE_CHECKING, Any, Final

from tests.link.model import Direction
from tests.link.profile import load

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.link.profile import DirectionSettings, Profile

PROFILE: Final = "modem-56k"
_HEADERS: Final = Struct("!I24x")
"""28 bytes in place of the IP and UDP headers, so that these count; it identifies the packet."""


def put_behind(protocol: Any, *, seed: int, profile: Profile | None = None) -> None:
    """Put aioice's `protocol` behind a line, by default a modem's, until it is closed."""
    ways, transport = profile or load(PROFILE), protocol.transport
    came, goes = (
        partial(_hand_on, transport, how) for how in (protocol.datagram_received, transport.sendto)
    )
    protocol.datagram_received = Line("down", seed, came, ways.down).carry
    transport.sendto = Line("up", seed, goes, ways.up).carry


def _hand_on(transport: Any, how: Callable[[bytes, Any], None], data: bytes, address: Any) -> None:
    if not transport.is_closing():  # ICE closes those of its sockets that it does not need
        how(data, address)


class Line:
    """One direction; `hand_on` is called with each datagram that came through, and its address."""

    def __init__(
        self,
        way: str,
        seed: int,
        hand_on: Callable[[bytes, Any], None],
        settings: DirectionSettings,
    ) -> None:
        self._model = Direction(settings, seed=seed, way=way, start_s=time.monotonic())
        self._hand_on = hand_on
        self._addresses: list[Any] = []
        self._timer: asyncio.TimerHandle | None = None

    def carry(self, data: bytes, address: Any) -> None:
        if address not in self._addresses:
            self._addresses.append(address)
        headers = _HEADERS.pack(self._addresses.index(address))
        self._model.arrive(headers + data, time.monotonic())
        self._arm()

    def _arm(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        next_s = self._model.next_s()
        if next_s < float("inf"):
            wait_s = max(0.0, next_s - time.monotonic())
            self._timer = asyncio.get_running_loop().call_later(wait_s, self._come)

    def _come(self) -> None:
        for _, packet in self._model.due(time.monotonic()):
            (number,) = _HEADERS.unpack_from(packet)
            self._hand_on(packet[_HEADERS.size :], self._addresses[number])
        self._arm()
