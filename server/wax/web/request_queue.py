"""In which order strangers' requests begin: a few in each pass of the event loop, in turns.

Whoever pays for a request must be able to, and those who pay take turns. So one address that asks
without end waits behind itself, and everybody else for four requests at most. What is urgent has
two a pass for itself, in turns as well.
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
_URGENT_IN_A_PASS: Final = 2


class WaitingRequest:
    """One that waits; `leave` when its connection has gone."""

    __slots__ = ("_line", "payer", "run")

    def __init__(self, line: _Line, payer: Payer, run: Callable[[], None]) -> None:
        self._line = line
        self.payer = payer
        self.run = run

    def leave(self) -> None:
        self._line.leave(self)


class RequestQueue:
    """Everything is called from the event loop."""

    def __init__(self, turnstile: Turnstile) -> None:
        self._turnstile = turnstile
        self._urgent = _Line(turnstile, _URGENT_IN_A_PASS)
        self._others = _Line(turnstile, _BEGIN_IN_A_PASS)
        self._next: asyncio.Handle | None = None
        self._next_is_soon = False

    def enter(
        self, payer: Payer, run: Callable[[], None], *, ahead: bool = False
    ) -> WaitingRequest | None:
        """Call `run` now or, where it has to wait, return what waits.

        Those `ahead` have a line of their own, which does not wait until strangers' work has time.
        """
        line = self._urgent if ahead else self._others
        is_open = ahead or self._turnstile.is_open
        waiting = line.enter(payer, run, is_open=is_open)
        self._come_back(0.0)
        return waiting

    def _go_on(self) -> None:
        self._next, self._next_is_soon = None, False
        self._urgent.begun = self._others.begun = 0
        wait_s = self._urgent.go_on(lambda: True)
        wait_s = min(wait_s, self._others.go_on(lambda: self._turnstile.is_open))
        if wait_s < float("inf"):
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


class _Line:
    """Those who wait, by who pays, and how many have begun in this pass; `most` may."""

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

    def leave(self, waiting: WaitingRequest) -> None:
        """Forget one that waits; nothing happens if it does not, any more."""
        others = self._waiting.get(waiting.payer, deque())
        if waiting in others:
            others.remove(waiting)
            if not others:
                del self._waiting[waiting.payer]

    def go_on(self, is_open: Callable[[], bool]) -> float:
        """Begin what may; return how long those who are left wait, infinity if there are none."""
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
