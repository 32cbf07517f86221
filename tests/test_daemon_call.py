"""A blocking call in a thread of its own."""

from __future__ import annotations

import asyncio
import threading

import pytest

from wax.daemon_call import daemon_call


async def test_what_a_call_raises_is_raised() -> None:
    """An exception of the call is raised to the caller."""
    assert await daemon_call("count", lambda: 7) == 7
    with pytest.raises(ZeroDivisionError):
        await daemon_call("divide", lambda: 1 // 0)


async def test_a_call_that_nobody_waits_for_ends_in_silence() -> None:
    """A caller can be cancelled at once; a late result or exception is discarded."""
    go_on = threading.Event()

    def hang() -> None:
        go_on.wait(5)
        raise OSError("too late")

    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.01):
            await daemon_call("hangs", hang)
    (thread,) = (one for one in threading.enumerate() if one.name == "hangs")
    assert thread.daemon
    go_on.set()
    thread.join(5)  # an exception in a thread fails the test
