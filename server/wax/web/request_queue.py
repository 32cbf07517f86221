"""The order in which strangers' requests start: a few in each pass of the event loop.

A payer needs a budget that is not used up, and payers take turns. So an address that floods waits
behind itself, and anybody else for four requests at most. Two urgent ones start in each pass
besides, in turns as well.
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
"""A request costs half a millisecond in all, spread over this pass and the next ones."""
_URGENT_IN_A_PASS: Final = 2


class WaitingRequest:
    """A queued request; `cancel` it when its connection is lost."""

    __slots__ = ("_queue", "payer", "run")

    def __init__(self, queue: _PayerQueue, payer: Payer, run: Callable[[], None]) -> None:
        self._queue = queue
        self.payer = payer
        self.run = run

    def cancel(self) -> None:
        self._queue.remove(self)


class RequestQueue:
    """Call everything from the event loop."""

    def __init__(self, turnstile: Turnstile) -> None:
        self._turnstile = turnstile
        self._urgent = _PayerQueue(turnstile, _URGENT_IN_A_PASS)
        self._others = _PayerQueue(turnstile, _BEGIN_IN_A_PASS)
        self._next: asyncio.Handle | None = None
        self._next_is_soon = False

    def enter(
        self, payer: Payer, run: Callable[[], None], *, urgent: bool = False
    ) -> WaitingRequest | None:
        """Call `run` now and return None, or queue and return it.

        Urgent requests have a queue of their own, which goes on when strangers' time is used up.
        """
        queue = self._urgent if urgent else self._others
        is_open = urgent or self._turnstile.is_open
        waiting = queue.enter(payer, run, is_open=is_open)
        self._plan(0.0)
        return waiting

    def _start_due(self) -> None:
        self._next, self._next_is_soon = None, False
        self._urgent.begun = self._others.begun = 0
        wait_s = self._urgent.start_due(lambda: True)
        wait_s = min(wait_s, self._others.start_due(lambda: self._turnstile.is_open))
        if wait_s < float("inf"):
            self._plan(wait_s)

    def _plan(self, wait_s: float) -> None:
        """Plan the next start, after this time or in the next pass; an earlier plan stays."""
        if self._next is not None:
            if self._next_is_soon or wait_s > 0:
                return
            self._next.cancel()
        loop = asyncio.get_running_loop()
        self._next_is_soon = wait_s <= 0
        if self._next_is_soon:
            self._next = loop.call_soon(self._start_due)
        else:
            self._next = loop.call_later(wait_s, self._start_due)


class _PayerQueue:
    """Waiting requests by payer, and how many have begun in this pass, at most `most`."""

    def __init__(self, turnstile: Turnstile, most: int) -> None:
        self._turnstile = turnstile
        self._most = most
        self._waiting: dict[Payer, deque[WaitingRequest]] = {}
        self.begun = 0

    def enter(
        self, payer: Payer, run: Callable[[], None], *, is_open: bool
    ) -> WaitingRequest | None:
        has_turn = is_open and payer not in self._waiting and self.begun < self._most
        if has_turn and self._turnstile.wait_s(payer) <= 0:
            self.begun += 1
            run()
            return None
        waiting = WaitingRequest(self, payer, run)
        self._waiting.setdefault(payer, deque()).append(waiting)
        return waiting

    def remove(self, waiting: WaitingRequest) -> None:
        """Remove a request that still waits; does nothing for any other."""
        others = self._waiting.get(waiting.payer, deque())
        if waiting in others:
            others.remove(waiting)
            if not others:
                del self._waiting[waiting.payer]

    def start_due(self, is_open: Callable[[], bool]) -> float:
        """Start what may start; return how long the rest must wait, infinity if none is left."""
        wait_s = float("inf")
        for payer in list(self._waiting):
            if self.begun >= self._most or not is_open():
                return 0.0
            if (own_s := self._turnstile.wait_s(payer)) > 0:
                wait_s = min(wait_s, own_s)
                continue
            others = self._waiting.pop(payer)
            first = others.popleft()
            if others:
                self._waiting[payer] = others
                wait_s = 0.0
            self.begun += 1
            first.run()
        return wait_s
