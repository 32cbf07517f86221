"""Many deliveries do not delay timers."""

from __future__ import annotations

import asyncio
import time
from functools import partial

from wax.fanout.batches import PORTION, in_batches

WORK_S = 0.002


async def test_each_call_is_made_once_and_in_order() -> None:
    """Every call is made once and in order, the first batch at once."""
    for count in (0, 1, PORTION, 2 * PORTION + 1):
        made: list[int] = []
        in_batches([partial(made.append, number) for number in range(count)])
        assert made == list(range(min(count, PORTION)))
        for _ in range(count):
            await asyncio.sleep(0)
        assert made == list(range(count))


async def test_what_is_spread_first_comes_to_each_first() -> None:
    """No lane gets a later item before an earlier one."""
    places = range(3 * PORTION)
    got: dict[int, list[str]] = {place: [] for place in places}
    for what in ("first", "second"):
        in_batches([partial(got[place].append, what) for place in places])
    for _ in places:
        await asyncio.sleep(0)
    assert set(map(tuple, got.values())) == {("first", "second")}


async def test_a_timer_is_served_between_the_batches() -> None:
    """A timer that is due does not wait for the last call."""
    made: list[int] = []
    served_after: list[int] = []
    ended = asyncio.Event()
    asyncio.get_running_loop().call_later(WORK_S, lambda: served_after.append(len(made)))

    def work(number: int) -> None:
        time.sleep(WORK_S)
        made.append(number)

    in_batches([*(partial(work, number) for number in range(5 * PORTION)), ended.set])
    await ended.wait()
    assert served_after
    assert served_after[0] <= 2 * PORTION
