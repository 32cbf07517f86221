"""A household's router: translates addresses, and forwards a few ports (RFC 4787). Pure.

The mapping does not depend on the other end; what comes in must come from an address and port that
was sent to before, as with most routers. A forwarded port takes what comes from anybody.
"""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, Final

from e2e.reach.packet import Port, read, with_source, with_target

if TYPE_CHECKING:
    from collections.abc import Collection

_FIRST_PORT: Final = 40_000


class Nat:
    """One router with the address `public`, before the one host `inside`."""

    def __init__(self, public: str, inside: str, forwards: Collection[tuple[int, int]]) -> None:
        self.public = public
        self._inside = inside
        self._forwards = frozenset(forwards)
        self._ports = count(_FIRST_PORT)
        self._outer: dict[tuple[int, int], int] = {}
        self._inner: dict[tuple[int, int], int] = {}
        self._spoken_to: set[tuple[int, int, Port]] = set()

    def forget(self) -> None:
        """Lose the mappings, as by a restart; what goes out gets new ports."""
        self._outer.clear()
        self._inner.clear()
        self._spoken_to.clear()

    def outward(self, packet: bytes) -> bytes | None:
        """Translate what the host sends; None for what is not translated."""
        flow = read(packet)
        if flow is None or flow.source.host != self._inside:
            return None
        own = flow.protocol, flow.source.port
        outer = own[1] if own in self._forwards else self._outer.get(own)
        if outer is None:
            outer = self._outer[own] = next(self._ports)
            self._inner[flow.protocol, outer] = own[1]
        self._spoken_to.add((flow.protocol, outer, flow.target))
        return with_source(packet, Port(self.public, outer))

    def inward(self, packet: bytes) -> bytes | None:
        """Translate what comes for the host; None for what is refused."""
        flow = read(packet)
        if flow is None:
            return None
        outer = flow.protocol, flow.target.port
        if outer in self._forwards:
            return with_target(packet, Port(self._inside, outer[1]))
        inner = self._inner.get(outer)
        if inner is None or (*outer, flow.source) not in self._spoken_to:
            return None
        return with_target(packet, Port(self._inside, inner))
