"""Deliver to many in small portions, so that what has a deadline is served between them."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

PORTION: Final = 4
"""To send one picture to one viewer takes up to half a millisecond."""


def in_portions(calls: Sequence[Callable[[], None]]) -> None:
    """Make the first calls now, the next ones in each following pass of the event loop.

    asyncio looks at its timers once a pass, so twenty deliveries in one would make the control
    loop's beat as late as they take. What is spread first comes to each of its places first.
    """
    for call in calls[:PORTION]:
        call()
    rest = calls[PORTION:]
    if rest:
        asyncio.get_running_loop().call_soon(in_portions, rest)
