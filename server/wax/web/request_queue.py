"""In which order strangers' requests begin: a few in each pass of the event loop, in turns.

Whoever pays for a request must be able to, and those who pay take turns. So one address that asks
without end waits behind itself, and everybody else for four requests at most.
"""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.edge.budget import Payer
    from wax.edge.turnstile import Turnstile

_BEGIN_IN_A_PASS: Final = 4
"""What a request costs falls into this pass and the next ones: together half a millisecond."""


class WaitingRequest:
    """One that waits; `leave` when its connection has gone."""

    __slots__ = ("_queue", "payer", "run")

    def __init__(self, queue: RequestQueue, payer: Payer, run: Callable[[], None]) -> None:
        self._queue = queue
        self.payer = payer
        self.run = run

    def leave(self) -> None:
        self._queue.leave(self)


class RequestQueue:
    """Everything is called from the event loop."""

    def __init__(self, turnstile: Turnstile) -> None:
        self._turnstile = turnstile
        self._waiting: dict[Payer, deque[WaitingRequest]] = {}
        self._begun = 0
        self._next: asyncio.Handle | None = None
        self._next_is_soon = False

    def enter(
        self, payer: Payer, run: Callable[[], None], *, ahead: bool = False
    ) -> WaitingRequest | None:
        """Call `run` now or, where it has to wait, return what waits; `ahead` passes the others."""
        is_first = ahead or (
            payer not in self._waiting
            and self._begun < _BEGIN_IN_A_PASS
            and self._turnstile.is_open
        )
        if is_first and self._turnstile.wait_s(payer) <= 0:
            self._begin(run)
            return None
        waiting = WaitingRequest(self, payer, run)
        self._waiting.setdefault(payer, deque()).append(waiting)
        self._come_back(0.0)
        return waiting

    def leave(self, waiting: WaitingRequest) -> None:
        """Forget one that waits; nothing happens if it does not, any more."""
        others = self._waiting.get(waiting.payer, deque())
        if waiting in others:
            others.remove(waiting)
            if not others:
                del self._waiting[waiting.payer]

    def _begin(self, run: Callable[[], None]) -> None:
        self._begun += 1
        self._come_back(0.0)
        run()

    def _go_on(self) -> None:
        self._next, self._next_is_soon, self._begun = None, False, 0
        wait_s = float("inf")
        for payer in list(self._waiting):
            if self._begun >= _BEGIN_IN_A_PASS or not self._turnstile.is_open:
                wait_s = 0.0
                break
            if (own_s := self._turnstile.wait_s(payer)) > 0:
                wait_s = min(wait_s, own_s)
                continue
            others = self._waiting.pop(payer)
            first = others.popleft()
            if others:
                self._waiting[payer] = others
                wait_s = 0.0
            self._begin(first.run)
        if self._waiting:
            self._come_back(wait_s)

    def _come_back(self, wait_s: float) -> None:
        """Go on after this time, or in the next pass; what is planned for earlier stays."""
        if self._next is not None:
            if self._next_is_soon or wait_s > 0:
                return
            self._next.cancel()
        loop = asyncio.get_running_loop()
        self._next_is_soon = wait_s <= 0
        if self._next_is_soon:
            self._next = loop.call_soon(self._go_on)
        else:
            self._next = loop.call_later(wait_s, self._go_on)
