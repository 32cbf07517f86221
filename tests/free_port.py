"""Ports for programs whose port must be known before they open it."""

from __future__ import annotations

import itertools
import os
import socket
from contextlib import suppress
from typing import Final

_FIRST: Final = 20_000
_MANY: Final = 12_000
"""Below the ports that systems give out themselves, so that nobody else gets one."""
_NUMBERS: Final = itertools.count(os.getpid() * 97)
"""Each process of the tests starts elsewhere."""


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    """Return a free port of the loopback interface, another one each time."""
    while True:
        port = _FIRST + next(_NUMBERS) % _MANY
        with socket.socket(socket.AF_INET, kind) as probe, suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
