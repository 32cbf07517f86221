"""The page's suite, short: each measurement finds what it measures."""

from __future__ import annotations

import pytest

from e2e.harness.missing import missing
from e2e.load.page import main_thread, presented
from e2e.load.page.first_picture import first_picture
from e2e.load.page.input_to_gate import input_to_gate
from e2e.load.page.memory import memory
from e2e.load.page.ways import WAYS, Way
from e2e.measure.errors import NotRunError

pytestmark = pytest.mark.timeout(300)


async def test_the_first_picture_moves() -> None:
    """Later than the page is asked for, and within a person's patience; stock's, too."""
    try:
        ours, stock = await first_picture("internet-5m", 10_000.0, "stock", 2)
    except NotRunError as error:
        missing(str(error))
    assert (ours.n, ours.met) == (2, True)
    assert ours.spread is not None
    # No page is there before its request has crossed the line twice.
    assert ours.spread.min > 80
    assert (stock.values["median"] or 0) > 80


@pytest.mark.parametrize("way", WAYS, ids=[way.key for way in WAYS])
async def test_each_way_moves_the_robot(way: Way) -> None:
    """Every press by it is seen on the robot's line, after it was made."""
    rows = await input_to_gate(way, 8)
    for row in rows:
        assert row.n >= 7
        assert row.spread is not None
        # Clocks are known to a fraction of a millisecond.
        assert -1 < row.spread.min < 500


async def test_the_main_thread_works(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some of the time is spent in tasks, and not all of it."""
    monkeypatch.setattr(main_thread, "SECONDS", 5.0)
    share, stock, _ = await main_thread.main_thread(1)
    for row in (share, stock):
        assert 0 < (row.values["median"] or 0) < 100


async def test_pictures_are_presented_by_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page while it drives, and the bare video, show about as many."""
    monkeypatch.setattr(presented, "SECONDS", 5.0)
    (row,) = await presented.presented(1)
    assert 50 < (row.values["median"] or 0) < 150


async def test_the_heap_is_read() -> None:
    """After a minute and a half of driving it is some megabytes, and what grew is known."""
    (row,) = await memory(2)
    assert row.n >= 4
    assert all(0.5 < mib < 100 for mib in row.detail["heap_mib"])
