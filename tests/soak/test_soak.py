"""Viewers leave nothing behind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import pytest
from e2e.load.crowd.crowd import gathered
from e2e.load.memory import BATCHES, FLAT_MIB, come_and_go
from e2e.load.servers import WAX, serving
from e2e.strangers.soak import Hand, Sample, Soaked, rows, soak

if TYPE_CHECKING:
    from wax.client import Operator


@pytest.mark.system
@pytest.mark.alone
@pytest.mark.full
@pytest.mark.timeout(240)
async def test_half_a_minute_of_coming_and_going_leaves_nothing() -> None:
    """There are as many threads, descriptors and tasks as before; somebody drove throughout."""
    found = await soak(30.0)
    assert found.joins >= 10
    assert len(found.samples) >= 10
    assert found.left == 0


@pytest.mark.system
@pytest.mark.alone
@pytest.mark.full
@pytest.mark.timeout(1800)
async def test_a_thousand_who_joined_and_left_leave_nothing() -> None:
    """No thread, descriptor or task is left, and no memory."""
    async with serving(WAX) as server, gathered(server.offering) as crowd:
        leaked_mib, left = await come_and_go(server, crowd, 1000 // BATCHES)
    assert left == 0
    assert leaked_mib <= FLAT_MIB


def _soaked(last_mib: float, last_ms: float | None, *, left: int = 0, stops: int = 0) -> Soaked:
    samples = [
        Sample(at=n / 600, rss_mib=100.0, sound_ms=50.0, picture_ms=20.0, trip_ms=1.0)
        for n in range(500)
    ]
    samples += [Sample(n / 600, last_mib, last_ms, 20.0, 1.0) for n in range(500, 600)]
    return Soaked(1800.0, samples, ["no reason"] * stops, 120, left)


def test_what_has_not_grown_is_met() -> None:
    """A machine's own variation explains two MiB and five milliseconds."""
    assert all(row.met for row in rows(_soaked(102.0, 55.0)))


@pytest.mark.parametrize(
    ("found", "missed"),
    [
        (_soaked(102.1, 50.0), "soak: memory"),
        (_soaked(100.0, 55.1), "soak: delay"),
        (_soaked(100.0, 50.0, left=1), "soak: left"),
        (_soaked(100.0, 50.0, stops=1), "soak: stops"),
    ],
)
def test_what_grows_or_is_left_is_missed(found: Soaked, missed: str) -> None:
    """Each goal is judged by itself."""
    assert [row.key for row in rows(found) if not row.met] == [missed]


class Fingers:
    """An operator whose presses are counted."""

    held = False
    presses = 0

    def let_go(self) -> None:
        self.held = False

    def steer(self, linear: float, angular: float) -> None:
        assert (linear, angular) != (0.0, 0.0)
        self.held = True
        self.presses += 1


NO: dict[str, Any] = {"moving": False, "reason": None}
YES: dict[str, Any] = {"moving": True, "reason": None}


async def test_only_what_stops_by_itself_is_a_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each stop counts once, with its first reason; standing before a press does not count."""
    monkeypatch.setattr("e2e.strangers.soak._PRESS_S", 0.0)
    fingers, stops = Fingers(), list[str]()
    hand = Hand(cast("Operator", fingers), stops)
    await hand.keep_on(0.0, {})
    assert fingers.presses == 1
    for at_s, status in ((0.1, NO), (0.2, YES), (5.0, NO), (5.1, NO), (5.5, YES), (9.0, NO)):
        hand.told(status, at_s)
        await hand.keep_on(at_s + 1.0, {})
    assert stops == ["no reason"] * 2
    assert fingers.presses == 1, "it may go on by itself"
    await hand.keep_on(11.1, {"commands.refused.blind": 2.0, "commands.refused.too_old": 1.0})
    hand.told(NO, 11.2)
    assert (fingers.presses, len(stops)) == (2, 2)
    counts = {"commands.accepted": 9.0, "commands.refused.blind": 5.0}
    await hand.keep_on(13.2, counts | {"commands.refused.too_old": 1.0})
    met = {"commands.refused.blind": 3}
    assert stops[2:] == [f"moves nothing when pressed: no reason {met}"]
    fingers.let_go()
    hand.told(YES, 13.3)
    hand.told(NO, 13.4)
    assert len(stops) == 3
