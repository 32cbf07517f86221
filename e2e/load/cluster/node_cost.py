"""What an observer costs the node in whose room they watch: its processor, and the wire."""

from __future__ import annotations

import asyncio
import sys
import time
from asyncio.subprocess import PIPE
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools

from e2e.harness.wait import eventually
from e2e.load.cluster.engine import installed, quiet_log
from e2e.load.cluster.published import are_live, rooms
from e2e.load.process import ProcessMeter, pinned, two_cores
from e2e.load.servers import WAX, serving
from e2e.measure.errors import NotRunError
from e2e.measure.row import Row
from e2e.measure.suite import ROOT
from e2e.measure.summary import summarize
from e2e.peers.livekit.installation import find_server

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Sequence

OBSERVERS: Final = 16
"""More do not fit on their core, since LiveKit's SDK decodes what comes."""
_SETTLE_S: Final = 4.0
_WINDOW_S: Final = 8.0
_ENTER_S: Final = 30.0
_STOP_S: Final = 5.0


@dataclass(frozen=True, slots=True)
class Costs:
    """Of one window, a second: processor time, and bytes and packets of the loopback interface."""

    cpu: float
    wire_bytes: float
    packets: float


async def node_cost(n: int) -> list[Row]:
    """Measure `n` pairs of windows, with nobody in the room and with `OBSERVERS`.

    The node has a core of its own. Raises `NotRunError`.
    """
    cores = two_cores()
    if cores is None:
        raise NotRunError("this needs two cores and a way to pin processes to them (Linux)")
    node_core, others_core = cores
    async with AsyncExitStack() as leaving:
        engine = installed(leaving.enter_context(quiet_log()))
        leaving.push_async_callback(engine.stop)
        with pinned(node_core):
            await engine.start()
        leaving.enter_context(pinned(others_core))
        server = await leaving.enter_async_context(serving(WAX, others_core, publish=rooms(engine)))
        await eventually(lambda: are_live(server, 2), "both rooms are published to", within_s=20)
        subscribers = await leaving.enter_async_context(_subscribers(engine.url(0)))
        nodes = _nodes()
        pairs = [
            [await _window(subscribers, count, nodes) for count in (0, OBSERVERS)] for _ in range(n)
        ]
    return [
        _row("cpu", "what an observer costs the node", "% of a core", _each(pairs, "cpu", 100)),
        _row("bytes", "… and is sent, all headers", "Mbit/s", _each(pairs, "wire_bytes", 8e-6)),
        _row("packets", "… in packets", "/s", _each(pairs, "packets", 1)),
    ]


def _each(pairs: Sequence[Sequence[Costs]], name: str, scale: float) -> list[float]:
    """Return what one observer more cost in each pair."""
    return [(getattr(many, name) - getattr(none, name)) / OBSERVERS * scale for none, many in pairs]


def _row(key: str, what: str, unit: str, values: Sequence[float]) -> Row:
    spread = summarize(values)
    found = spread.model_dump(exclude={"n", "mean", "sd"})
    return Row(key=f"node: {key}", what=what, n=len(values), unit=unit, values=found, spread=spread)


def _nodes() -> list[ProcessMeter]:
    """Return the nodes that this process has started; that without observers costs the same."""
    program = find_server().resolve()
    children = psutil.Process().children()
    return [ProcessMeter(one.pid) for one in children if Path(one.exe()) == program]


async def _window(subscribers: Process, count: int, nodes: Sequence[ProcessMeter]) -> Costs:
    assert subscribers.stdin is not None
    assert subscribers.stdout is not None
    subscribers.stdin.write(f"{count}\n".encode())
    async with asyncio.timeout(_ENTER_S):
        await subscribers.stdout.readline()
    await asyncio.sleep(_SETTLE_S)
    before_s, cpu_s, wire = time.monotonic(), _cpu_s(nodes), _loopback()
    await asyncio.sleep(_WINDOW_S)
    took_s, after = time.monotonic() - before_s, _loopback()
    return Costs(
        (_cpu_s(nodes) - cpu_s) / took_s,
        (after[0] - wire[0]) / took_s,
        (after[1] - wire[1]) / took_s,
    )


def _cpu_s(nodes: Sequence[ProcessMeter]) -> float:
    return sum(one.cpu_s() for one in nodes)


def _loopback() -> tuple[int, int]:
    """Return bytes and packets that this machine has sent itself so far."""
    counted = psutil.net_io_counters(pernic=True)["lo"]
    return counted.bytes_sent, counted.packets_sent


@asynccontextmanager
async def _subscribers(url: str) -> AsyncIterator[Process]:
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "e2e.load.cluster.subscribers", url),
        stdin=PIPE,
        stdout=PIPE,
        cwd=ROOT,
    )
    try:
        yield process
    finally:
        assert process.stdin is not None
        process.stdin.close()
        try:
            await asyncio.wait_for(process.wait(), _STOP_S)
        except TimeoutError:
            process.kill()
            await process.wait()
