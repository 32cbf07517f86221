"""How cells are repeated: what fails, what is a result, what hangs."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import psutil
import pytest

from e2e.delay import watch
from e2e.delay.cell import Cell
from e2e.delay.judging import found, goals, judge
from e2e.delay.measures import measured
from e2e.instrument.synthetic import OPENED_MS, readings
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Callable

BLIND: Any = {"problem": "there was no picture within 30 s"}


def cell(system: str, **more: Any) -> Cell:
    return Cell.model_validate({"profile": "lan", "system": system, **more})


def giving(monkeypatch: pytest.MonkeyPatch, found: Callable[[Cell], Any]) -> None:
    async def once(one: Cell) -> Any:
        return found(one)

    monkeypatch.setattr(watch, "_once", once)


async def test_each_repetition_is_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """The row has its figures by name and its cell, whose number seeds the link."""
    giving(monkeypatch, lambda one: ({"picture_age_p50_ms": float(one.repeat)}, {}))
    rows = await watch.repeated(cell("operator"), 2)
    assert [row.values["picture_age_p50_ms"] for row in rows] == [0, 1]
    assert [Cell.model_validate(row.detail["cell"]).key for row in rows] == [
        "lan/operator/0",
        "lan/operator/1",
    ]


async def test_only_ours_must_have_a_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """For a peer, or for the thesis's policy, having no picture is a result."""
    giving(monkeypatch, lambda _: ({}, dict(BLIND)))
    for system in ("stock", "thesis"):
        (row,) = await watch.repeated(cell(system), 1)
        assert row.detail["problem"] == BLIND["problem"]
    with pytest.raises(MeasureError, match="no picture"):
        await watch.repeated(cell("operator"), 1)


async def test_a_crowd_that_finds_no_room_misses_every_goal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where server and machine do not carry the crowd, no figure was reached."""

    def crowded(_: Cell) -> Any:
        raise watch.CrowdError("viewer 34 sees or hears nothing in 20 s")

    giving(monkeypatch, crowded)
    (row,) = await watch.repeated(cell("operator", profile="same-machine", viewers=41), 1)
    (goal,) = (one for one in goals() if one.kind == "crowd")
    assert judge(goal, found([row])).met is False
    assert row.detail["problem"] == "viewer 34 sees or hears nothing in 20 s"


@pytest.mark.timeout(90)
async def test_a_hung_cell_is_cut_off_and_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A cell that does not end is ended, with its browser and its link."""

    async def hang(*_: object) -> Any:
        await asyncio.Event().wait()

    monkeypatch.setattr(watch, "_watch", hang)
    monkeypatch.setattr(watch, "BEYOND_S", 5.0)
    before = set(psutil.Process().children(recursive=True))
    with pytest.raises(MeasureError, match="it hung and was cut off after 5 s"):
        await watch.repeated(cell("stock", seconds=0.0), 1)
    left = set(psutil.Process().children(recursive=True)) - before
    assert not [one for one in left if one.is_running() and "chromium" in one.name()]


def test_what_was_never_reached_is_told_where_the_link_changed() -> None:
    """After an outage that never ends the figures are None; without an outage there are none."""
    page = readings(5)
    found = measured(cell("operator", profile="outage"), page, 3.0, OPENED_MS)
    assert found["picture_recovered_ms"] is found["full_after_ms"] is None
    assert "picture_recovered_ms" not in measured(cell("operator"), page, 3.0, OPENED_MS)
