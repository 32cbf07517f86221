"""The bytes on a viewer's state channel while another viewer does all to make them many."""

from __future__ import annotations

import asyncio
import itertools
import time
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING, Any, Final

import pytest
from e2e.harness import toml
from e2e.harness.server import Server

from wax.client import Client

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

VIEWERS: Final = 12
MEASURED_S: Final = 8.0
MOST_BYTES_A_SECOND: Final = 2000
FLOOD_PAUSE_S: Final = 0.01

SAID: dict[str, Callable[[int], dict[str, Any]]] = {
    "names": lambda n: {"type": "name", "name": f"{n} " * 20},
    "the queue": lambda n: {"type": "join" if n % 2 else "leave"},
    "stops": lambda n: (
        {"type": "stop"}
        if n % 2
        else {"type": "release", "stop": n // 2, "sent_server_ms": 0.0, "beat": None}
    ),
}
"""Each key floods in another way; the test runs them all together."""


@pytest.mark.system
@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_flood_of_one_is_hardly_noticed_by_the_others(tmp_path: Path) -> None:
    """Each gets at most 2 kB a second with twelve viewers, whatever one of them repeats."""
    server = Server(tmp_path, toml.CARD)
    await server.start()
    try:
        async with AsyncExitStack() as stack:

            async def enter(number: int) -> Client:
                client = Client(
                    server.url, name=f"Somebody with number {number}", sound=False, picture=False
                )
                return await stack.enter_async_context(client)

            viewers = [await enter(number) for number in range(VIEWERS)]
            heard = viewers[0]
            bytes_heard = 0

            def count(data: str | bytes) -> None:
                nonlocal bytes_heard
                bytes_heard += len(data)

            heard.state.on("message", count)
            for what in (*SAID, "all"):
                says = [SAID[what]] if what in SAID else list(SAID.values())
                await asyncio.sleep(1.0)
                bytes_heard = 0
                began_s = time.monotonic()
                for number in itertools.count():
                    if (took_s := time.monotonic() - began_s) >= MEASURED_S / len(SAID):
                        break
                    viewers[-1].send(**says[number % len(says)](number))
                    await asyncio.sleep(FLOOD_PAUSE_S)
                assert bytes_heard / took_s <= MOST_BYTES_A_SECOND, what
            # The last name counts, and everybody gets it.
            await asyncio.sleep(1.0)
            viewers[-1].send(type="name", name="The last")

            def knows() -> bool:
                lines = heard.newest("room")["viewers"]
                return "The last" in [line["name"] for line in lines]

            assert await heard.until(knows, 6.0)
            assert len(heard.newest("room")["viewers"]) == VIEWERS
        await server.stop()
    finally:
        await server.kill()
