"""The network between one peer and the server: it can be cut, delay packets and lose them.

Real UDP sockets on the server's own address: the peer is told of the relay in the server's place,
and the server learns where its peer is from whoever calls, as it does with every page.
"""

from __future__ import annotations

import asyncio
import re
import time
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any, Final, Literal

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Callable

_CANDIDATE: Final = re.compile(
    r"^(?P<begin>a=candidate:\S+ \d+ udp \d+) (?P<host>[0-9.]+) (?P<port>\d+) typ host",
    re.IGNORECASE,
)

_DATA_CHANNELS: Final = range(20, 64)
"""First bytes of DTLS (RFC 7983)."""
_COMMAND_BYTES: Final = 120
"""Smaller packets of a raw peer's channels are acknowledgements and heartbeats."""

Address = tuple[str | Any, int]
Way = Literal["up", "down"]
"""``up`` is towards the server."""


@dataclass(frozen=True, slots=True)
class Weather:
    """Each packet's independent delay, uniform about `delay_ms`, and loss."""

    delay_ms: float = 0.0
    jitter_ms: float = 0.0
    loss: float = 0.0


CALM: Final = Weather()


class Relay:
    """One peer's way to the server and back; `weather` holds for both directions."""

    def __init__(self, weather: Weather = CALM) -> None:
        self.weather = weather
        self.last_command_s = 0.0
        """When the last command that came through is forwarded to the server."""
        self.worst_late_s = 0.0
        """The longest delay of a packet past its time, which is this machine's fault."""
        self._is_cut = False
        self._random = Random(2004)
        self._near = _Socket(self._from_peer)
        self._far = _Socket(self._from_server)
        self._peer: Address | None = None
        self._server: Address | None = None

    def offer(self, sdp: str) -> str:
        """Make the peer reachable through the relay only."""
        lines = [line for line in sdp.splitlines() if not line.startswith("a=candidate:")]
        return "\r\n".join(lines) + "\r\n"

    async def answer(self, sdp: str) -> str:
        """Open the sockets anew; return the server's answer with the relay in its place."""
        self.close()
        self._server = _candidate(sdp)
        host = self._server[0]
        await self._near.open(host)
        await self._far.open(host)
        return _only(sdp, self._near.address)

    def close(self) -> None:
        """Safe to call twice, and before `answer`."""
        self._near.close()
        self._far.close()

    def cut(self) -> None:
        """Drop everything from now on, in both directions, including packets in flight."""
        self._is_cut = True

    def mend(self) -> None:
        self._is_cut = False

    def _from_peer(self, data: bytes, source: Address) -> None:
        self._peer = source
        self._pass_on("up", data, self._far, self._server)

    def _from_server(self, data: bytes, source: Address) -> None:
        self._pass_on("down", data, self._near, self._peer)

    def _pass_on(self, way: Way, data: bytes, out: _Socket, to: Address | None) -> None:
        now_s = time.monotonic()
        weather = self.weather
        lost = self._is_cut or to is None or self._random.random() < weather.loss
        swing_ms = self._random.uniform(-weather.jitter_ms, weather.jitter_ms)
        delay_s = max(0.0, weather.delay_ms + swing_ms) / 1000
        if lost or to is None:
            return
        if way == "up" and data[0] in _DATA_CHANNELS and len(data) >= _COMMAND_BYTES:
            self.last_command_s = max(self.last_command_s, now_s + delay_s)
        if delay_s == 0:
            out.send(data, to)
            return
        loop = asyncio.get_running_loop()
        loop.call_later(delay_s, self._arrive, now_s + delay_s, data, out, to)

    def _arrive(self, due_s: float, data: bytes, out: _Socket, to: Address) -> None:
        if not self._is_cut:
            self.worst_late_s = max(self.worst_late_s, time.monotonic() - due_s)
            out.send(data, to)


class _Socket(asyncio.DatagramProtocol):
    """One UDP socket; `address` is its own, once it is open."""

    def __init__(self, take: Callable[[bytes, Address], None]) -> None:
        self._take = take
        self._transport: asyncio.DatagramTransport | None = None
        self.address = ("", 0)

    async def open(self, host: str) -> None:
        loop = asyncio.get_running_loop()
        self._transport, _ = await loop.create_datagram_endpoint(lambda: self, local_addr=(host, 0))
        self.address = self._transport.get_extra_info("sockname")[:2]

    def close(self) -> None:
        if self._transport is not None:
            self._transport.close()

    def send(self, data: bytes, to: Address) -> None:
        if self._transport is not None and not self._transport.is_closing():
            self._transport.sendto(data, to)

    def datagram_received(self, data: bytes, addr: Address) -> None:
        self._take(data, addr)

    def error_received(self, exc: Exception) -> None:
        """Ignore a closed port, as with a network whose other end is gone."""


def _candidate(sdp: str) -> tuple[str, int]:
    for line in sdp.splitlines():
        match = _CANDIDATE.match(line)
        if match:
            return match["host"], int(match["port"])
    raise MeasureError("this machine has no IPv4 address that the relay could take part on")


def _only(sdp: str, address: tuple[str, int]) -> str:
    """Give each section one candidate, at `address`."""
    lines: list[str] = []
    wanted = True
    for line in sdp.splitlines():
        match = _CANDIDATE.match(line)
        if line.startswith("m="):
            wanted = True
        if match and wanted:
            wanted = False
            lines.append(f"{match['begin']} {address[0]} {address[1]} typ host")
        elif not line.startswith("a=candidate:"):
            lines.append(line)
    return "\r\n".join(lines) + "\r\n"
