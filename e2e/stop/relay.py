"""The network between one peer and the server: it can be cut, delay packets and lose them.

It lies between the peer's ICE and its own sockets.
"""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass
from functools import partial
from random import Random
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    Send = Callable[[bytes, Any], None]

_DATA_CHANNELS: Final = range(20, 64)
"""First bytes of DTLS (RFC 7983)."""
_COMMAND_BYTES: Final = 120
"""Smaller packets of a raw peer's channels are acknowledgements and heartbeats."""


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

    def tap(self, protocol: Any) -> None:
        """Lie between aioice's `protocol` and its socket, from now on."""
        transport = protocol.transport
        up = partial(_send, transport, transport.sendto)
        transport.sendto = partial(self._pass_on, up, is_up=True)
        protocol.datagram_received = partial(self._pass_on, protocol.datagram_received, is_up=False)

    def cut(self) -> None:
        """Drop everything from now on, in both directions, including packets in flight."""
        self._is_cut = True

    def mend(self) -> None:
        self._is_cut = False

    def _pass_on(self, send: Send, data: bytes, address: Any, *, is_up: bool) -> None:
        now_s = time.monotonic()
        weather = self.weather
        lost = self._is_cut or self._random.random() < weather.loss
        swing_ms = self._random.uniform(-weather.jitter_ms, weather.jitter_ms)
        delay_s = max(0.0, weather.delay_ms + swing_ms) / 1000
        if lost:
            return
        if is_up and data[0] in _DATA_CHANNELS and len(data) >= _COMMAND_BYTES:
            self.last_command_s = max(self.last_command_s, now_s + delay_s)
        if delay_s == 0:
            send(data, address)
            return
        loop = asyncio.get_running_loop()
        loop.call_later(delay_s, self._arrive, now_s + delay_s, send, data, address)

    def _arrive(self, due_s: float, send: Send, data: bytes, address: Any) -> None:
        if not self._is_cut:
            self.worst_late_s = max(self.worst_late_s, time.monotonic() - due_s)
            send(data, address)


def _send(transport: Any, sendto: Send, data: bytes, address: Any) -> None:
    if not transport.is_closing():  # ICE gives up those of its sockets that it does not need
        sendto(data, address)
