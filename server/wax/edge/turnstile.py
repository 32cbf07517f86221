"""Limits strangers' work in each pass of the event loop, and decides who waits.

asyncio runs its timers, and with them the control loop, once a pass. So the datagrams of all guests
together get two milliseconds of each pass, or a tenth of a longer one; so do all requests; and the
rest waits for the next: no command of the operator's waits for more than that. Requests and peers
are apart so that no flood by HTTP delays a Stop that comes by a channel. The tenth is needed while
the loop is busy: with few passes a second, what arrives would otherwise wait ever longer.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from heapq import nlargest
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.edge.budget import Payer

_PASS_S: Final = 0.002
_PASS_SHARE: Final = 0.1
_WOKEN: Final = 2
"""Waiting payers of either kind that go on in each pass even if others use it up first; as many
more as a long pass has more time."""


class Turnstile:
    """Make one for the event loop, and call everything here from it."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._is_next_due, self._planned_s = False, 0.0
        self._peers, self._requests = _Lane(), _Lane()
        self.charged_s = 0.0
        """The time charged to all payers since the start."""
        self._entries, self._waited_s = 0, 0.0

    @property
    def has_time_for_peers(self) -> bool:
        """Whether a guest's datagram may still be handled in this pass."""
        return self._peers.is_open

    @property
    def is_open(self) -> bool:
        """Whether work for a request may still begin in this pass."""
        return self._requests.is_open

    def wait_s(self, payer: Payer) -> float:
        """Return how long a payer's debt makes it wait, else 0; the pass's limit is `is_open`."""
        return payer.wait_s(self._clock.now_s())

    def charge(self, payer: Payer, began_s: float) -> None:
        """Charge this thread's processor time since `began_s`, a value of `time.thread_time()`."""
        self._charge(self._requests, payer, began_s)

    def charge_peer(self, payer: Payer, began_s: float) -> None:
        """Do the same for a peer's datagrams."""
        self._charge(self._peers, payer, began_s)

    async def enter_peer(self, payer: Payer) -> None:
        """Wait until there is time for a datagram of a peer."""
        self._entries += 1
        turn = self._turn(self._peers, payer)
        if turn is not None:
            began_s = self._clock.now_s()
            await turn
            self._waited_s += self._clock.now_s() - began_s

    @property
    def peers_waited(self) -> tuple[int, float]:
        """How many of their datagrams have come here, and how long these have waited together."""
        return self._entries, self._waited_s

    def request_turn(self, payer: Payer) -> asyncio.Future[None] | None:
        """Return what is done once there is time for the next step of answering a request.

        None if there is now. Whoever need not wait any longer sets its result.
        """
        return self._turn(self._requests, payer)

    def _charge(self, lane: _Lane, payer: Payer, began_s: float) -> None:
        cost_s = time.thread_time() - began_s
        lane.used_s += cost_s
        self.charged_s += cost_s
        payer.spend(cost_s, self._clock.now_s())
        self._plan_next_pass()

    def _turn(self, lane: _Lane, payer: Payer) -> asyncio.Future[None] | None:
        if lane.is_open and payer not in lane.waiting:
            return None
        self._plan_next_pass()
        return lane.enter(payer)

    def _plan_next_pass(self) -> None:
        if not self._is_next_due:
            self._is_next_due, self._planned_s = True, self._clock.now_s()
            asyncio.get_running_loop().call_soon(self._next_pass)

    def _next_pass(self) -> None:
        self._is_next_due = False
        now_s = self._clock.now_s()
        limit_s = max(_PASS_S, _PASS_SHARE * (now_s - self._planned_s))
        for lane in (self._peers, self._requests):
            lane.next_pass(limit_s, now_s)
            if lane.waiting:
                self._plan_next_pass()


class _Lane:
    """One kind of strangers' work: its time in this pass, and the payers that wait for the next.

    Those who have used least go first: on a loop with too much to do, the Stop of an observer does
    not wait until twenty others' reports have been read.
    """

    def __init__(self) -> None:
        self.used_s, self._limit_s = 0.0, _PASS_S
        self.waiting: dict[Payer, deque[asyncio.Future[None]]] = {}

    @property
    def is_open(self) -> bool:
        return self.used_s < self._limit_s

    def enter(self, payer: Payer) -> asyncio.Future[None]:
        turn = asyncio.get_running_loop().create_future()
        self.waiting.setdefault(payer, deque()).append(turn)
        return turn

    def next_pass(self, limit_s: float, now_s: float) -> None:
        self.used_s, self._limit_s = 0.0, limit_s
        woken = int(_WOKEN * limit_s / _PASS_S)
        for payer in nlargest(woken, self.waiting, key=lambda one: one.credit_s(now_s)):
            turns = self.waiting.pop(payer)
            while turns and turns[0].done():  # it was cancelled, or waits no longer
                turns.popleft()
            if turns:
                turns.popleft().set_result(None)
            if turns:
                self.waiting[payer] = turns


class Meter:
    """One peer at the turnstile.

    While the peer is trusted, as the operator and the host are, it pays from an account of its own
    that no honest page ever uses up, and does not wait for others' work.
    """

    def __init__(
        self,
        turnstile: Turnstile,
        guest: Payer,
        trusted: Payer | None = None,
        is_trusted: Callable[[], bool] = lambda: False,
    ) -> None:
        self._turnstile = turnstile
        self._guest = guest
        self._trusted = trusted
        self._is_trusted = is_trusted

    @property
    def _payer(self) -> Payer:
        if self._trusted is not None and self._is_trusted():
            return self._trusted
        return self._guest

    @property
    def is_open(self) -> bool:
        """Whether this peer's traffic may be handled now."""
        payer = self._payer
        has_room = payer is self._trusted or self._turnstile.has_time_for_peers
        return has_room and self._turnstile.wait_s(payer) <= 0

    def charge(self, began_s: float) -> None:
        """Charge this peer (`Turnstile.charge`)."""
        self._turnstile.charge_peer(self._payer, began_s)

    async def enter(self) -> None:
        """Wait until this peer's traffic may be handled."""
        while (wait_s := self._turnstile.wait_s(self._payer)) > 0:  # noqa: ASYNC110 - by a clock
            await asyncio.sleep(wait_s)
        if self._payer is not self._trusted:
            await self._turnstile.enter_peer(self._payer)
