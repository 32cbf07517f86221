"""Which sockets the event loop serves in one pass: of the connections that came in, only a few.

asyncio serves every socket that is ready before it looks at its timers. Hundreds of connections
that end at once would take a tenth of a second, and with it the robot's next set-point.
"""

from __future__ import annotations

import asyncio
import selectors
import socket
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from wax.edge.binding import LISTENING

if TYPE_CHECKING:
    from collections.abc import Callable

    from _typeshed import FileDescriptorLike

    from wax.edge.step_watch import StepWatch

CONNECTIONS_IN_A_PASS: Final = 4
"""Each costs a third of a millisecond until it has ended, here and in the next passes, and a TLS
handshake 0.6 ms, or 6 with an RSA key of 4096 bits."""


@dataclass(slots=True)
class _Connection:
    sender: str
    is_known: bool
    served_at: int


class BoundedSelector(selectors.DefaultSelector):
    """The platform's selector, which leaves connections beyond the first few for the next pass.

    Their senders take turns, by `sender_of` an address, and each one's connections, too: whoever
    has one waits behind one of each other's. Senders for whom `is_known` holds pass the
    others, of whom one is served then. Sockets of our own are always served. `rests` is called
    before it waits.
    """

    def __init__(
        self,
        sender_of: Callable[[str], str],
        rests: Callable[[], None],
        is_known: Callable[[str], bool] = lambda _: False,
    ) -> None:
        super().__init__()
        self._sender_of = sender_of
        self._is_known = is_known
        self._rests = rests
        self._connections: dict[int, _Connection] = {}
        self._passes = 0

    def register(
        self, fileobj: FileDescriptorLike, events: int, data: Any = None
    ) -> selectors.SelectorKey:
        key = super().register(fileobj, events, data)
        self._connections.pop(key.fd, None)  # that of a socket which was closed before
        peer = _peer_of(key.fd)
        if peer is not None:
            sender = self._sender_of(peer)
            self._connections[key.fd] = _Connection(sender, self._is_known(sender), self._passes)
        return key

    def unregister(self, fileobj: FileDescriptorLike) -> selectors.SelectorKey:
        key = super().unregister(fileobj)
        self._connections.pop(key.fd, None)
        return key

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        self._rests()
        ready = super().select(timeout)
        if len(ready) <= CONNECTIONS_IN_A_PASS:
            return ready
        connections = self._connections
        theirs = [one for one in ready if one[0].fd in connections]
        if len(theirs) <= CONNECTIONS_IN_A_PASS:
            return ready
        theirs.sort(key=lambda one: connections[one[0].fd].served_at)
        turns = Counter[str]()
        in_turns: list[tuple[bool, int, int]] = []
        for place, (key, _) in enumerate(theirs):
            one = connections[key.fd]
            turns[one.sender] += 1
            in_turns.append((not one.is_known, turns[one.sender], place))
        in_turns.sort()
        first = in_turns[:CONNECTIONS_IN_A_PASS]
        if not first[-1][0]:
            first += [turn for turn in in_turns if turn[0]][:1]
        served = [theirs[place] for *_, place in first]
        self._passes += 1
        for key, _ in served:
            connections[key.fd].served_at = self._passes
        return [one for one in ready if one[0].fd not in connections] + served


def bounded_loop(
    sender_of: Callable[[str], str],
    watch: StepWatch,
    is_known: Callable[[str], bool] = lambda _: False,
) -> asyncio.AbstractEventLoop:
    loop = asyncio.SelectorEventLoop(BoundedSelector(sender_of, watch.rests, is_known))
    watch.ready.extend(loop._ready)  # type: ignore[attr-defined]
    loop._ready = watch.ready  # type: ignore[attr-defined]
    return loop


def _peer_of(fd: int) -> str | None:
    """Return the address at the other end of a connection that came in; None for other sockets.

    "" for one that was reset: nobody knows any more.
    """
    try:
        found = socket.socket(fileno=fd)
    except OSError:  # no socket
        return None
    try:
        if found.type != socket.SOCK_STREAM or found.family not in (
            socket.AF_INET,
            socket.AF_INET6,
        ):
            return None
        port = found.getsockname()[1]
        if LISTENING.get(fd) == port or port not in LISTENING.values():
            return None
        return str(found.getpeername()[0])
    except OSError:
        return ""
    finally:
        found.detach()
