"""How many files and sockets the server may have open, and how many connections fit into that."""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Final

if sys.platform != "win32":
    import resource

if TYPE_CHECKING:
    from wax.config.settings import Settings

_OURS: Final = 128
"""Cameras, the robot, records and the event loop itself; most are open at the start."""
_PER_VIEWER: Final = {"one-port": 4, "full-ice": 16}
"""One-port: a socket for each path to a viewer's browser, two of which may be tried at once.
Full ICE: a socket for each of this machine's addresses, and for relays."""
_LEAST: Final = 16
"""The minimum of `[server] max_connections`."""
_OPEN_MAX: Final = 10_240
"""What macOS allows at most where it calls its limit infinite (its setrlimit(2))."""


def limit(*, hard: bool = False) -> int | None:
    """Return how many may be open, now or after `raise_limit` (`hard`); None without a limit."""
    if sys.platform == "win32":
        return None
    found = resource.getrlimit(resource.RLIMIT_NOFILE)[1 if hard else 0]
    return None if found == resource.RLIM_INFINITY else found


def raise_limit() -> None:
    """Raise the limit to this user's maximum: shells set 1,024, and programs ask for more."""
    if sys.platform == "win32":
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    for wanted in (hard, max(soft, _OPEN_MAX)):
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
            return


def connections_that_fit(settings: Settings, most: int | None) -> int:
    """Return how many HTTP connections fit into a limit of `most`, beside all viewers' sockets."""
    server = settings.server
    if most is None:
        return server.max_connections
    others = _OURS + server.max_viewers * _PER_VIEWER[settings.network.mode]
    return max(_LEAST, min(server.max_connections, most - others))
