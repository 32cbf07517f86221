"""The network between one peer and the server, which can be cut.

It sits between the peer's ICE and its own sockets.
"""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    Send = Callable[[bytes, Any], None]

_DATA_CHANNELS: Final = range(20, 64)
"""First bytes of DTLS (RFC 7983)."""
_COMMAND_BYTES: Final = 120
"""Smaller packets of a raw peer's channels are acknowledgements and heartbeats."""


def is_command(packet: bytes) -> bool:
    """Return whether this is a command; because it is encrypted, only its size tells."""
    return len(packet) >= _COMMAND_BYTES and packet[0] in _DATA_CHANNELS


class Relay:
    """One peer's path to the server and back."""

    def __init__(self) -> None:
        self.last_command_s = 0.0
        """When the last command that came through was forwarded to the server."""
        self._is_cut = False

    def tap(self, protocol: Any) -> None:
        """Sit between aioice's `protocol` and its socket from now on."""
        transport, received = protocol.transport, protocol.datagram_received
        transport.sendto = partial(self._pass_on, transport.sendto, is_up=True)
        protocol.datagram_received = partial(self._pass_on, received, is_up=False)

    def cut(self) -> None:
        """Drop everything from now on, in both directions."""
        self._is_cut = True

    def mend(self) -> None:
        self._is_cut = False

    def _pass_on(self, send: Send, data: bytes, address: Any, *, is_up: bool) -> None:
        if self._is_cut:
            return
        if is_up and is_command(data):
            self.last_command_s = time.monotonic()
        send(data, address)
