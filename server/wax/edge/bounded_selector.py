"""Limits how many incoming connections the event loop serves in one pass.

asyncio serves every ready socket before it runs its timers. Hundreds of connections that end at
once would take a tenth of a second, and so delay the robot's next set-point.
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
"""Each costs a third of a millisecond until it ends, in this pass and the next ones, and a TLS
handshake 0.6 ms, or 6 ms with an RSA key of 4096 bits."""


@dataclass(slots=True)
class _Connection:
    sender: str
    is_known: bool
    served_at: int


class BoundedSelector(selectors.DefaultSelector):
    """The platform's selector, which serves a few incoming connections in each pass.

    Senders (`sender_of` an address) take turns, and so do each sender's connections: a sender's
    only one waits for at most one of every other sender's. Those of `is_known` senders go first,
    and of the others at least one is served. Our own sockets are always served. `before_wait` is
    called before each wait.
    """

    def __init__(
        self,
        sender_of: Callable[[str], str],
        before_wait: Callable[[], None],
        is_known: Callable[[str], bool] = lambda _: False,
    ) -> None:
        super().__init__()
        self._sender_of = sender_of
        self._is_known = is_known
        self._before_wait = before_wait
        self._connections: dict[int, _Connection] = {}
        self._passes = 0

    def register(
        self, fileobj: FileDescriptorLike, events: int, data: Any = None
    ) -> selectors.SelectorKey:
        key = super().register(fileobj, events, data)
        self._connections.pop(key.fd, None)  # a closed socket had this number
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
        self._before_wait()
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
    loop = asyncio.SelectorEventLoop(BoundedSelector(sender_of, watch.end_step, is_known))
    watch.ready.extend(loop._ready)  # type: ignore[attr-defined]
    loop._ready = watch.ready  # type: ignore[attr-defined]
    return loop


def _peer_of(fd: int) -> str | None:
    """Return an incoming connection's client address; None for any other socket.

    It is "" for a connection that was reset: its address is no longer known.
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
