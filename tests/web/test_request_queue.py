"""A flooding address waits behind itself; everybody else is served in the next pass."""

from __future__ import annotations

import asyncio
import time
from typing import Final

from tests.turned_clock import TurnedClock

from wax.edge.turnstile import Turnstile
from wax.web.request_budgets import HOST, RequestBudgets
from wax.web.request_queue import RequestQueue

PASS: Final = 4


class Bed:
    """A queue and the order in which requests began."""

    def __init__(self) -> None:
        self.clock = TurnedClock()
        self.turnstile = Turnstile(self.clock)
        self.queue = RequestQueue(self.turnstile)
        self.budgets = RequestBudgets(self.turnstile)
        self.begun: list[str] = []

    def ask(self, address: str, name: str, *, urgent: bool = False) -> bool:
        """Return whether a request of this address, or of somebody known, begins at once."""
        budgets = self.budgets
        payer = budgets.of_known(address, address) if urgent else budgets.of_guest(address)
        assert payer is not None
        return self.queue.enter(payer, lambda: self.begun.append(name), urgent=urgent) is None

    def spend(self, address: str, cost_s: float) -> None:
        self.turnstile.charge(self.budgets.of_guest(address), time.thread_time() - cost_s)


async def passes(number: int) -> None:
    for _ in range(number):
        await asyncio.sleep(0)


async def test_a_few_begin_in_each_pass() -> None:
    """Forty requests at once are spread over ten passes, and addresses take turns."""
    bed = Bed()
    for number in range(39):
        bed.ask("flood", str(number))
    bed.ask("guest", "guest")
    assert len(bed.begun) == PASS
    await passes(1)
    assert len(bed.begun) <= 2 * PASS
    await passes(2)
    assert "guest" in bed.begun
    await passes(60)
    assert len(bed.begun) == 40
    assert [one for one in bed.begun if one != "guest"] == [str(n) for n in range(39)]


async def test_an_address_with_no_budget_left_waits() -> None:
    """Others do not wait, and the address goes on once its budget has refilled."""
    bed = Bed()
    for _ in range(2):
        bed.spend("flood", 1.0)
    await passes(2)
    assert not bed.ask("flood", "flood")
    assert bed.ask("guest", "guest")
    await passes(3)
    assert bed.begun == ["guest"]
    bed.clock.time_s += 2.0
    bed.ask("guest", "wakes the queue")
    await passes(3)
    assert bed.begun[-1] == "flood"


async def test_urgent_requests_pass_the_others() -> None:
    """The host's, or a known person's Stop, start at an address that waits, in a full pass."""
    bed = Bed()
    for _ in range(2):
        bed.spend("flood", 1.0)
    assert not bed.turnstile.is_open
    assert not bed.ask("flood", "flood")
    assert bed.ask("ada", "stop", urgent=True)
    assert bed.ask(HOST, "host", urgent=True)
    assert bed.begun == ["stop", "host"]


async def test_urgent_requests_have_a_share_and_take_turns() -> None:
    """Ten people who flood with them delay neither another's for long, nor other requests."""
    bed = Bed()
    for number in range(10):
        for _ in range(48):
            bed.ask(f"troll {number}", "release", urgent=True)
    bed.ask("ada", "stop", urgent=True)
    bed.ask("guest", "guest")
    assert bed.begun == ["release", "release", "guest"]
    for number in range(1, 7):
        await passes(1)
        assert bed.begun.count("release") <= 2 * (number + 1)
    assert "stop" in bed.begun


async def test_a_cancelled_request_does_not_begin() -> None:
    """A lost connection's request is removed, and may be cancelled again."""
    bed = Bed()
    for number in range(PASS):
        bed.ask("x", str(number))
    waiting = bed.queue.enter(bed.budgets.of_guest("x"), lambda: bed.begun.append("gone"))
    assert waiting is not None
    waiting.cancel()
    waiting.cancel()
    await passes(5)
    assert bed.begun == ["0", "1", "2", "3"]


async def test_a_reserve_can_be_used_up() -> None:
    """A known person who floods pays like any guest, until they have paused."""
    bed = Bed()
    payer = bed.budgets.of_known("troll", "x")
    assert payer is not None
    for _ in range(40):
        bed.turnstile.charge(payer, time.thread_time() - 0.05)
    assert bed.budgets.of_known("troll", "x") is None
    assert bed.budgets.of_known("ada", "x") is not None
    bed.clock.time_s += 5.0
    assert bed.budgets.of_known("troll", "x") is payer


async def test_an_address_below_a_page_a_second_never_waits() -> None:
    """Whatever others do, ten cheap requests of an address begin at once."""
    bed = Bed()
    for number in range(30):
        bed.spend(f"troll {number}", 1.0)
    guest = bed.budgets.of_guest("guest")
    for _ in range(10):
        assert bed.turnstile.wait_s(guest) == 0
        bed.turnstile.charge(guest, time.thread_time() - 0.0005)


def test_a_budget_outlives_its_connections() -> None:
    """A returning address still has its debt; only the least recently used of 1,024 is dropped."""
    budgets = RequestBudgets(Turnstile(TurnedClock()))
    first = budgets.of_guest("0")
    for number in range(1, 1024):
        budgets.of_guest(str(number))
    assert budgets.of_guest("0") is first
    second = budgets.of_guest("1")
    for number in range(1024):
        budgets.of_guest(f"new {number}")
    assert budgets.of_guest("1") is not second
