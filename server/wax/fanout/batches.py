"""Deliver to many viewers in small batches, so that timers can run in between."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

PORTION: Final = 4
"""Sending one picture to one viewer takes about a fifth of a millisecond."""


def in_batches(calls: Sequence[Callable[[], None]], portion: int = PORTION) -> None:
    """Make the first calls now, and the next batch in each following pass of the event loop.

    asyncio checks its timers once a pass, so twenty deliveries in one pass would delay the control
    loop. Every lane receives its items in order.
    """
    for call in calls[:portion]:
        call()
    rest = calls[portion:]
    if rest:
        asyncio.get_running_loop().call_soon(in_batches, rest, portion)
