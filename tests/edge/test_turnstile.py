"""The turnstile: strangers' work fits into a small part of each pass of the event loop."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

import pytest
from tests.turned_clock import TurnedClock

from wax.edge.budget import Budget, Rates
from wax.edge.turnstile import Meter, Turnstile

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from wax.edge.budget import Payer

    Work = Callable[[float], None]


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Work:
    """Return what adds seconds to this thread's processor time."""
    worked = [0.0]
    monkeypatch.setattr(time, "thread_time", lambda: worked[0])

    def work(for_s: float) -> None:
        worked[0] += for_s

    return work


def payer(committed: float = 1.0) -> Payer:
    return Budget(Rates(committed, 10 * committed, 0.0, 0.0)).payer("")


async def test_what_does_not_fit_waits_for_the_next_pass(work: Work) -> None:
    """Of forty strangers with a millisecond of work each, no more than three run in a pass."""
    turnstile = Turnstile(TurnedClock())
    passes: list[int] = []
    now = 0

    async def stranger() -> None:
        meter = Meter(turnstile, payer())
        await meter.enter()
        began_s = time.thread_time()
        passes.append(now)
        work(0.001)
        meter.charge(began_s)

    tasks = [asyncio.create_task(stranger()) for _ in range(40)]
    while not all(task.done() for task in tasks):
        now += 1
        await asyncio.sleep(0)
    assert max(passes.count(one) for one in passes) <= 3
    assert len(passes) == 40


async def test_requests_and_peers_leave_each_other_their_time(work: Work) -> None:
    """What one of the two has used up is no less for the other."""
    turnstile = Turnstile(TurnedClock())
    meter = Meter(turnstile, payer())
    began_s = time.thread_time()
    work(0.01)
    turnstile.charge(payer(), began_s)
    assert (turnstile.is_open, meter.is_open) == (False, True)
    await asyncio.sleep(0)
    meter.charge(began_s)
    assert (turnstile.is_open, meter.is_open) == (True, False)


async def test_a_long_pass_has_room_for_more(work: Work) -> None:
    """While a pass takes 100 ms, strangers get a tenth of it, and no more."""
    clock = TurnedClock()
    turnstile = Turnstile(clock)
    passes: list[int] = []
    now = 0

    async def stranger() -> None:
        await turnstile.enter_peer(who := payer())
        began_s = time.thread_time()
        passes.append(now)
        work(0.001)
        turnstile.charge_peer(who, began_s)

    tasks = [asyncio.create_task(stranger()) for _ in range(60)]
    while not all(task.done() for task in tasks):
        now += 1
        clock.time_s += 0.1
        await asyncio.sleep(0)
    counts = [passes.count(one) for one in sorted(set(passes))]
    assert counts[1:-1] == [10] * len(counts[1:-1])
    assert len(counts) < 9


async def test_payers_take_turns_while_newcomers_use_up_each_pass(work: Work) -> None:
    """A payer with a hundred waiting steps delays neither another's request nor a peer."""
    turnstile = Turnstile(TurnedClock())
    flooder, guest, viewer = payer(), payer(), payer()
    entered: list[tuple[Payer, int]] = []
    used: list[float] = []

    async def request(who: Payer) -> None:
        turn = turnstile.request_turn(who)
        if turn is not None:
            await turn

    async def step(enter: Callable[[Payer], Awaitable[None]], who: Payer) -> None:
        await enter(who)
        entered.append((who, len(used)))
        began_s = time.thread_time()
        work(0.001)
        used[-1] += 0.001
        turnstile.charge(who, began_s)

    def uses_it_up() -> None:
        used.append(0.003)
        began_s = time.thread_time()
        work(0.003)
        turnstile.charge(payer(), began_s)

    uses_it_up()
    for _ in range(50):
        gone = turnstile.request_turn(flooder)
        assert gone is not None
        gone.set_result(None)  # whoever waited is gone
    tasks = [asyncio.create_task(step(request, flooder)) for _ in range(100)]
    await asyncio.sleep(0)
    tasks[7].cancel()
    for who, enter in ((guest, request), (viewer, turnstile.enter_peer)):
        tasks.append(asyncio.create_task(step(enter, who)))
    while not all(task.done() for task in tasks):
        uses_it_up()
        await asyncio.sleep(0)
    assert len(entered) == 101
    assert all(at < 5 for who, at in entered if who is not flooder)
    assert max(used) < 0.007


async def test_the_waits_of_peers_are_known() -> None:
    """One datagram that goes on at once, and one that waits half a second for the next pass."""
    clock = TurnedClock()
    turnstile = Turnstile(clock)
    await turnstile.enter_peer(payer())
    turnstile._peers.used_s = 1.0
    waits = asyncio.create_task(turnstile.enter_peer(payer()))
    await asyncio.sleep(0)
    clock.time_s += 0.5
    await waits
    assert turnstile.peers_waited == (2, 0.5)


async def test_who_has_used_least_goes_first(work: Work) -> None:
    """An observer's datagram passes twenty viewers who came first and have used up more."""
    turnstile = Turnstile(TurnedClock())
    viewers, observer = [payer() for _ in range(20)], payer()
    order: list[Payer] = []

    async def step(who: Payer) -> None:
        await turnstile.enter_peer(who)
        order.append(who)

    tasks = [asyncio.create_task(step(one)) for one in [*viewers, observer]]
    began_s = time.thread_time()
    work(0.01)
    for one in viewers:
        turnstile.charge_peer(one, began_s)
    await asyncio.gather(*tasks)
    assert order.index(observer) < 2


async def test_a_trusted_peer_waits_for_nobody(work: Work) -> None:
    """The operator's commands pass when strangers have used up the pass and their accounts."""
    turnstile = Turnstile(TurnedClock())
    is_trusted = False
    meter = Meter(turnstile, payer(0.001), payer(), lambda: is_trusted)
    began_s = time.thread_time()
    work(0.1)
    meter.charge(began_s)
    assert not meter.is_open
    is_trusted = True
    assert meter.is_open
    await asyncio.wait_for(meter.enter(), 5)


async def test_even_a_trusted_peer_has_a_bound(work: Work) -> None:
    """An operator who floods must leave room for somebody else's Stop."""
    meter = Meter(Turnstile(TurnedClock()), payer(), payer(0.3), lambda: True)
    began_s = time.thread_time()
    work(4.0)
    meter.charge(began_s)
    assert not meter.is_open


async def test_a_debt_keeps_out_until_it_is_paid(work: Work) -> None:
    """The clock decides, however many passes the loop makes."""
    clock = TurnedClock()
    turnstile = Turnstile(clock)
    meter = Meter(turnstile, payer(0.01))
    began_s = time.thread_time()
    work(0.105)
    meter.charge(began_s)
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert not meter.is_open
    clock.time_s += 0.6
    assert meter.is_open
