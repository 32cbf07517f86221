"""Hundreds of connections that say nothing, or not enough, while others ask and are answered."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Final

import aiohttp
import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools

from e2e.harness import toml
from e2e.measure.row import counted, summed
from e2e.stop.stage import LIGHT, staged
from e2e.strangers.attacks import ATTACKS
from e2e.strangers.hostile import begin
from e2e.strangers.strangers import strangers

if TYPE_CHECKING:
    from e2e.harness.server import Server
    from e2e.measure.row import Row
    from e2e.stop.stage import Load

CLOSED_S: Final = 10.0
OTHERS_MS: Final = 200.0
_OTHERS_EVERY_S: Final = 0.05
_PATHS: Final = ("/", "/healthz", "/icon.svg")
_BACK_S: Final = 5.0
_LOOK_S: Final = 0.1
_LASTS_S: Final = 20.0
"""After that what is still open counts as never closed."""


async def slow_connections(n: int, *, load: Load = LIGHT) -> list[Row]:
    """Open them all, `n` times one after the other; others ask 20 times a second meanwhile."""
    lasted_s: dict[str, list[float | None]] = {}
    others_ms: list[float | None] = []
    left = 0
    async with staged(toml.as_shipped(), load=load) as stage:
        process = psutil.Process(stage.server.pid)
        await _ask(stage.server, "/")
        for _ in range(n):
            before = process.num_fds()
            async with strangers("attacks", stage.server.port) as dawdling:
                await begin(dawdling, "slow", _LASTS_S)
                asking = asyncio.create_task(_others(stage.server, others_ms))
                account = await dawdling.account()
                asking.cancel()
            for kind, values in account["lasted_s"].items():
                lasted_s.setdefault(kind, []).extend(values)
            left += await _left(process, before)
    every = [value for values in lasted_s.values() for value in values]
    return [
        summed(
            "slow-connections",
            f"{ATTACKS['slow'].what}: closed after",
            "s",
            every,
            CLOSED_S,
            by_kind_max_s={
                kind: max((s for s in values if s is not None), default=None)
                for kind, values in lasted_s.items()
            },
        ),
        summed(
            "slow-connections: others",
            "… others are answered meanwhile",
            "ms",
            others_ms,
            OTHERS_MS,
            judged="p99",
        ),
        counted("slow-connections: left", "… descriptors that are left", left, len(every)),
    ]


async def _others(server: Server, took_ms: list[float | None]) -> None:
    number = 0
    while True:
        number += 1
        took_ms.append(await _ask(server, _PATHS[number % len(_PATHS)]))
        await asyncio.sleep(_OTHERS_EVERY_S)


async def _ask(server: Server, path: str) -> float | None:
    """Ask over a new connection, as a new visitor does; return ms, None if it failed."""
    start_s = time.monotonic()
    try:
        code, _ = await server.get(path)
    except aiohttp.ClientError:
        return None
    return (time.monotonic() - start_s) * 1000 if code == 200 else None


async def _left(process: psutil.Process, before: int) -> int:
    """Return how many more descriptors there are than before; they get 5 s to be closed."""
    left = 0
    for _ in range(int(_BACK_S / _LOOK_S)):
        left = max(int(process.num_fds()) - before, 0)
        if not left:
            break
        await asyncio.sleep(_LOOK_S)
    return left
