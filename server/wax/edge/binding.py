"""Listening sockets: one port on every address of a host that this machine has."""

from __future__ import annotations

import errno
import socket
from typing import Any, Final

from wax.errors import reason_of

BACKLOG: Final = 512
"""Connections that the kernel queues: a class opens the page at once."""
LISTENING: Final[dict[int, int]] = {}
"""Ports by descriptor, of all sockets that `listen` ever opened here."""
NOT_HERE: Final = frozenset({errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT})
"""A name may have an address of a family that this machine does not use: ``::1 localhost`` stays in
`/etc/hosts` where IPv6 is off, as in most containers."""


def advice(error: OSError, key: str) -> str:
    """Return what to do when the port that `key` sets cannot be bound."""
    match error.errno:
        case errno.EADDRINUSE:
            return f"End the program that uses it (`ss -tulpn` names it), or choose another: {key}."
        case errno.EACCES:
            return (
                "A port below 1024 takes a right: uncomment CAP_NET_BIND_SERVICE in wax.service."
                f" Or choose one from 1024 on ({key}), to which a router or proxy forwards 443."
            )
        case errno.EADDRNOTAVAIL:
            return "Set server.host to an address of this machine, or to 0.0.0.0 for all."
    return f"Check server.host and the port: {key}."


def why_not(error: OSError, key: str) -> str:
    """Return why a port cannot be bound, and what to do."""
    reason, _, _ = reason_of(error).partition(" (while")  # Python repeats the address here
    return f"{reason}. {advice(error, key)}"


def addresses(
    host: str | None, port: int, kind: socket.SocketKind
) -> list[tuple[int, tuple[Any, ...]]]:
    """Return each address of a host to bind, after its family; raises `socket.gaierror`.

    ``localhost`` is this machine even without `/etc/hosts` or a resolver (RFC 6761, 6.3).
    """
    try:
        found = socket.getaddrinfo(host, port, type=kind, flags=socket.AI_PASSIVE)
    except socket.gaierror:
        if host != "localhost":
            raise
        return [(socket.AF_INET6, ("::1", port, 0, 0)), (socket.AF_INET, ("127.0.0.1", port))]
    return list(dict.fromkeys((family, address) for family, *_, address in found))


def listen(host: str, port: int) -> list[socket.socket]:
    """Return non-blocking sockets on one port (0: any); raises `OSError` if none can be bound.

    An address in use raises, too: half of the clients would not find the server.
    """
    made: list[socket.socket] = []
    missing: OSError | None = None
    try:
        for family, address in addresses(host, port, socket.SOCK_STREAM):
            # All share the port that the system chose for the first.
            same = (address[0], made[0].getsockname()[1] if made else port, *address[2:])
            try:
                one = socket.create_server(same, family=family, backlog=BACKLOG)
            except OSError as error:
                if error.errno not in NOT_HERE:
                    raise
                missing = error
                continue
            one.setblocking(False)
            made.append(one)
        if missing is not None and not made:
            raise missing
        LISTENING.update({one.fileno(): one.getsockname()[1] for one in made})
    except OSError:
        for one in made:
            one.close()
        raise
    return made
