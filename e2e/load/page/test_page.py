"""What is measured of the page, short: each measurement finds what it measures."""

from __future__ import annotations

import pytest

from e2e.harness.missing import missing
from e2e.load.page.first_picture import first_picture
from e2e.load.page.input_to_gate import input_to_gate
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
    for row in await input_to_gate(way, 8):
        assert row.n >= 7
        assert row.spread is not None
        # Clocks are known to a fraction of a millisecond.
        assert -1 < row.spread.min < 500
