"""One cell, on parts that do as they are told: what is measured when, and what is a failure."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import time
from contextlib import asynccontextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from tests.link.counters import Counters

from e2e.delay import watch as watching
from e2e.delay.cell import Cell
from e2e.delay.crowd import crowd
from e2e.delay.process import CostMeter
from e2e.delay.readings import Readings
from e2e.link import load
from e2e.link.statistics import Lateness, Statistics
from e2e.measure.errors import MeasureError
from wax.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.link import Link

CELL = Cell(experiment="E1", profile="lan", system="stock", seconds=3.2)


class FakeLink:
    """Carries ten packets and drops one between two looks, one in five of them late."""

    def __init__(self) -> None:
        self.profile = load("lan")
        self.said: list[str] = []
        self._looks = 0

    async def statistics(self) -> Statistics:
        self._looks += 1
        ways = Counters(packets_out=10 * self._looks, bytes_out=1000 * self._looks)
        ways.queue_drops = ways.losses = self._looks
        late = Lateness()
        for late_ms in [0.0, 0.0, 0.0, 0.0, 7.0] * self._looks:
            late.add(late_ms)
        return Statistics(1.0, 0.1, True, ways, ways, late, late)

    async def start_changes(self) -> float:
        self.said.append("changes")
        return asyncio.get_running_loop().time()


class FakePage:
    """A page and its instrument; `sees` is whether there is ever a picture."""

    def __init__(self, link: FakeLink, *, sees: bool) -> None:
        self._said = link.said
        self._sees = sees

    async def goto(self, url: str) -> None:
        self._said.append(f"goto {url}")

    async def evaluate(self, expression: str) -> Any:
        raise AssertionError(expression)

    async def sees_picture(self) -> bool:
        return self._sees

    async def hears(self, within_s: float) -> bool:
        self._said.append("hears")
        return True

    @property
    def recorded(self) -> list[object]:
        return []

    async def readings(self) -> Readings:
        self._said.append("readings")
        return Readings(opened_ms=1000.0, first_picture_ms=1500.0 if self._sees else None)


async def play(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, *, sees: bool
) -> tuple[Any, FakeLink]:
    link = FakeLink()
    page = FakePage(link, sees=sees)

    async def opened(window: object) -> None:
        link.said.append("opened")

    async def told() -> dict[str, float | str]:
        link.said.append("told")
        count = float(link.said.count("told"))
        return {"viewer.id": 1.0, "viewer.streams.skipped": 10 * count, "turn": count}

    @asynccontextmanager
    async def start(*_: object) -> AsyncIterator[Any]:
        yield SimpleNamespace(url="http://there", pid=os.getpid(), opened=opened, told=told)

    @asynccontextmanager
    async def window(preload: str) -> AsyncIterator[FakePage]:
        yield page

    monkeypatch.setattr(watching, "start", start)
    monkeypatch.setattr(watching, "Instrument", lambda *_, **__: page)
    monkeypatch.setattr(watching, "PICTURE_WITHIN_S", 0.2)

    async def cpu_s() -> float:
        return time.monotonic() / 4

    browser: Any = SimpleNamespace(window=window, ear=None, cpu_s=cpu_s)
    there: Any = link
    return await watching.watch(CELL, there, browser, tmp_path), link


async def test_a_cell_is_measured_in_its_order(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Page, picture, ear, the link's changes, the time, the readings; with costs and counts."""
    began_ms = SystemClock().wall_ms()
    found, link = await play(monkeypatch, tmp_path, sees=True)
    before, during = ["goto http://there", "opened", "hears"], ["changes", "told"]
    assert link.said == [*before, *during, "readings", "told"]
    assert found.problem is None
    assert (found.told["viewer.streams.skipped"], found.told["turn"]) == (10.0, 2.0)
    assert found.told["link.late_share"] == 0.2
    assert began_ms - 1 <= found.told["changes_began_ms"] <= SystemClock().wall_ms()
    assert (found.down.packets, found.down.bytes) == (10, 1000)
    assert (found.up.queue_drops, found.up.losses) == (1, 1)
    assert found.server.memory_mib > 1
    assert found.browser_cpu_share == pytest.approx(0.25, rel=0.1)


async def test_no_picture_is_a_failure_with_figures(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Without a picture in time the cell says so, and keeps what there was."""
    found, link = await play(monkeypatch, tmp_path, sees=False)
    assert found.problem == "there was no picture within 0 s"
    assert found.readings.first_picture_ms is None
    assert "changes" not in link.said


def test_counts_are_of_the_cells_own_time() -> None:
    """Earlier counts are subtracted; a viewer that rejoined starts from 0."""
    before: dict[str, float | str] = {"viewer.id": 1.0, "viewer.streams.fail_safe_s": 4.0}
    after: dict[str, float | str] = {"viewer.id": 1.0, "viewer.streams.fail_safe_s": 4.5}
    assert watching.since(before, after)["viewer.streams.fail_safe_s"] == 0.5
    assert watching.since(before, after | {"viewer.id": 2.0})["viewer.streams.fail_safe_s"] == 4.5
    assert watching.since({}, after) == after


def test_thin_links_are_waited_for_longer() -> None:
    """Where the page alone takes a while, the first picture has more time."""
    seconds = {}
    for name in ("lan", "same-machine", "modem-56k"):
        link: Any = SimpleNamespace(profile=load(name))
        seconds[name] = watching.picture_within_s(link)
    assert seconds["modem-56k"] > seconds["lan"] == seconds["same-machine"]


def test_a_process_is_counted_with_its_children() -> None:
    """What a child uses counts for its parent; one that has ended is told by its name."""
    busy = "import sys\nprint(flush=True)\nwhile True: pass"
    code = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {busy!r}])"
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, start_new_session=True
    ) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()
            meter = CostMeter(process.pid, "the server of stock")
            while (used := meter.read()).cpu_share < 0.01:
                pass
            assert used.memory_mib > 10  # two interpreters
        finally:
            os.killpg(process.pid, 9)
    with pytest.raises(MeasureError, match="the server of stock"):
        meter.read()


async def test_there_is_no_crowd_at_livekit() -> None:
    """Nobody posts an offer to a server that takes none: it is told instead."""
    cell = CELL.model_copy(update={"viewers": 3, "system": "livekit"})
    nowhere: Link = SimpleNamespace()  # type: ignore[assignment]
    with pytest.raises(MeasureError, match="was not built"):
        async with crowd(cell, nowhere, "http://127.0.0.1:9"):
            raise AssertionError


async def test_a_crowd_that_does_not_come_is_one_sentence() -> None:
    """Where nobody answers the crowd says so, and its process has ended."""
    spawned = []

    async def spawn_python(arguments: list[str], **options: Any) -> asyncio.subprocess.Process:
        process = await asyncio.create_subprocess_exec(
            sys.executable, *arguments, cwd=Path(__file__).parents[2], **options
        )
        spawned.append(process)
        return process

    end = SimpleNamespace(spawn_python=spawn_python)
    link: Link = SimpleNamespace(server=end)  # type: ignore[assignment]
    cell = CELL.model_copy(update={"viewers": 3})
    with pytest.raises(MeasureError, match="the crowd did not come together"):
        async with crowd(cell, link, "http://127.0.0.1:9"):
            raise AssertionError
    assert spawned[0].returncode is not None
