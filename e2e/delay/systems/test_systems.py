"""Whole sessions through the link, and browsers that are missing or broken."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import psutil
import pytest
import pytest_asyncio

from e2e.delay.browser import open_browser
from e2e.delay.cell import Cell
from e2e.delay.systems import start
from e2e.harness.installed import CHROMIUM, installed
from e2e.harness.robot import pose
from e2e.harness.viewer import PROBE
from e2e.harness.wait import eventually
from e2e.link import Link
from e2e.measure.errors import MeasureError, NotRunError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from playwright.async_api import Page


@pytest_asyncio.fixture(loop_scope="session")
async def link() -> AsyncIterator[Link]:
    async with Link("lan") as link:
        yield link


def cell(system: Any, **keys: Any) -> Cell:
    return Cell(experiment="E4", profile="lan", system=system, **keys)


@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    "cell", [cell("operator", drives=True), cell("stock")], ids=lambda cell: cell.system
)
async def test_a_session_runs_through_the_link(cell: Cell, link: Link, tmp_path: Path) -> None:
    """The browser at one end shows the test card and plays the sound of the server at the other."""
    async with start(cell, link, tmp_path) as running:
        before = await link.statistics()
        async with open_browser(link) as browser, browser.window(PROBE.read_text()) as window:
            await watch(cell, running, window)
            assert await browser.ear.tap().hears(within_s=10)
        after = await link.statistics()
        assert {"wax", "e2e.peers.stock"} & set(psutil.Process(running.pid).cmdline())
    assert not psutil.pid_exists(running.pid)
    assert after.down.bytes_out - before.down.bytes_out > 50_000


async def watch(cell: Cell, running: Any, window: Page) -> None:
    await window.goto(running.url)
    assert await window.evaluate("isSecureContext")
    at_first = await pose(running) if cell.drives else None
    plays = "waxProbe.playing()"
    await eventually(lambda: window.evaluate(plays), "the picture plays", within_s=20)
    await running.opened(window)
    assert all(card["valid"] for card in await window.evaluate("waxProbe.cards(3)"))
    if at_first is not None:
        assert [one["role"] for one in (await running.status())["viewers"]] == ["operator"]
        assert (await pose(running)).distance_m(at_first) > 0


async def test_the_end_of_the_log_is_told(link: Link, tmp_path: Path) -> None:
    """A server that ends at its start is an error with the last lines of its log."""
    wrong = cell("thesis", audio_mu_ms=123)
    with pytest.raises(
        MeasureError, match=r"(?s)ended with status 2; its log ends with: .*audio_mu_ms"
    ):
        async with start(wrong, link, tmp_path):
            pass


def test_a_missing_browser_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a browser the cell cannot run here, and the error says what to install."""
    monkeypatch.delenv("WAX_CHROMIUM", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NotRunError, match=r"^there is no "):
        installed(*CHROMIUM)


async def test_a_broken_browser_is_a_sentence(link: Link, monkeypatch: pytest.MonkeyPatch) -> None:
    """A browser that ends at once is an error that names it."""
    monkeypatch.setenv("WAX_CHROMIUM", "/bin/false")
    with pytest.raises(MeasureError, match=r"^Chromium does not start"):
        async with open_browser(link):
            pass
