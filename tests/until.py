"""Waits for conditions without an event; the limit only ends a hang, and is no deadline."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

_PATIENCE_S: Final = 30.0
_LOOK_S: Final = 0.002


def until(is_so: Callable[[], object]) -> None:
    """Wait for what other threads or processes do."""
    end_s = time.monotonic() + _PATIENCE_S
    while not is_so():
        assert time.monotonic() < end_s, "in vain"
        time.sleep(_LOOK_S)


async def async_until(is_so: Callable[[], object]) -> None:
    """Wait for what the event loop does, or others while it runs."""
    async with asyncio.timeout(_PATIENCE_S):
        while not is_so():  # noqa: ASYNC110
            await asyncio.sleep(_LOOK_S)
