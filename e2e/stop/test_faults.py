"""The suite, briefly: each fault stops the robot in time, and too late if a watchdog is slow."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, get_args

import pytest
import pytest_asyncio

from e2e.measure.errors import MeasureError
from e2e.measure.table import to_table
from e2e.stop import by_page
from e2e.stop.fault import measure, repeated, rows_of, set_up
from e2e.stop.faults import FAULTS
from e2e.stop.flooder import flooded
from e2e.stop.hand_over import Ending, hand_over
from e2e.stop.nuisance import nuisance
from e2e.stop.robots import BOARD, KINDS
from e2e.stop.stage import DEFAULT, LIGHT, staged

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from e2e.measure.row import Row
    from e2e.stop.fault import Fault, Scene
    from e2e.stop.robots import Kind

TRIALS = 2
_DEAF = """
for (const type of ["blur", "visibilitychange"])
    addEventListener(type, (event) => event.stopImmediatePropagation(), true);
"""
"""The page's own listeners never hear that its window has lost the keyboard or is hidden."""

BY_KEY = {fault.key: fault for fault in FAULTS}
ONE_STAGE = ("server-stopped", "serial-unplugged", "driver-killed", "hand")
BRIEF = {*ONE_STAGE, "network-vanishes", "browser-frozen"}
ROS2 = next(kind for kind in KINDS if kind.key == "ros2")

pytestmark = pytest.mark.timeout(180)


def assert_met(rows: Sequence[Row]) -> None:
    missed = [row for row in rows if not row.met]
    assert not missed, to_table(missed)


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def scene() -> AsyncIterator[Scene]:
    """Set up one stage, with a person aboard, for several faults."""
    async with set_up(BY_KEY["hand"], BOARD, LIGHT) as made:
        yield made


@pytest.mark.parametrize("key", ONE_STAGE)
async def test_a_fault_stops_the_robot(scene: Scene, key: str) -> None:
    """It stops in time, nothing late moves it, and driving again needs a new press."""
    assert_met(rows_of(BY_KEY[key], await repeated(BY_KEY[key], scene, TRIALS)))


@pytest.mark.parametrize(
    "key", ["network-vanishes", pytest.param("browser-frozen", marks=pytest.mark.full)]
)
async def test_an_operator_who_is_gone_stops_the_robot(key: str) -> None:
    """It is told to stop in 200 ms, or at full speed stops in 0.3 m, although the key is held."""
    assert_met(await measure(BY_KEY[key], _trials(BY_KEY[key]), load=LIGHT))


@pytest.mark.full
@pytest.mark.parametrize(
    "fault",
    [
        one
        for one in FAULTS
        if (len(one.kinds) > 1 or one.key not in BRIEF) and "flood" not in one.key
    ],
    ids=lambda one: str(one.key),
)
async def test_each_fault_stops_each_robot(fault: Fault) -> None:
    """Every fault of the table, on every robot that it can affect."""
    assert_met(await measure(fault, _trials(fault), load=LIGHT))


def _trials(fault: Fault) -> int:
    """Return how often to try; a fault whose trials would share the machine is tried once."""
    return TRIALS if fault.at_once == 1 else 1


@pytest.mark.full
@pytest.mark.parametrize("key", ["stop-in-flood", "stop-in-flood: own"])
async def test_stop_is_heard_in_a_flood(key: str) -> None:
    """A Stop is in time in a flood of 3,000 messages a second, which a busy machine can carry."""
    weak = replace(BY_KEY[key], prop=partial(flooded, rate_hz=3000.0))
    assert_met(await measure(weak, 4, load=LIGHT))


# --- each measure can fail -----------------------------------------------------------------------

_SLOW_GATE = {"drive": {"max_age_ms": 1000.0, "max_command_age_ms": 2000.0}}


@pytest.mark.full
@pytest.mark.parametrize(
    ("key", "kind", "settings"),
    [
        ("server-stopped", BOARD, _SLOW_GATE | {"robot": {"silence_ms": 1000}}),
        ("driver-killed", BOARD, {"robot": {"silence_ms": 120, "serial": {"ttl_ms": 1000}}}),
        ("driver-killed: standby", ROS2, {"robot": {"ros2": {"standby": False}}}),
        ("network-vanishes", BOARD, _SLOW_GATE),
    ],
    ids=["silence", "board", "standby", "age of a command"],
)
async def test_without_a_watchdog_the_stop_is_late(
    key: str, kind: Kind, settings: dict[str, Any]
) -> None:
    """Each deadline is missed on its own, although the next watchdog stops the robot later."""
    rows = await measure(BY_KEY[key], 1, kinds=[kind], load=LIGHT, **settings)
    assert not any(row.met for row in rows)


@pytest.mark.full
async def test_a_page_that_holds_on_does_not_stop() -> None:
    """The page's measurement fails if the page does not get the event."""
    deaf = replace(BY_KEY["another-tab"], prop=partial(by_page.tab, script=_DEAF))
    (row,) = await measure(deaf, 1, load=LIGHT)
    assert not row.met


@pytest.mark.full
async def test_a_load_that_did_not_hold_is_no_result() -> None:
    """If observers are gone at the end, none of the measurements counts."""

    async def lose_them() -> None:
        async with staged(load=replace(DEFAULT, observers=2)) as stage:
            assert stage.crowd is not None
            await stage.crowd.hold(0)
            await stage.server.until(lambda told: not told["viewers"], "the observers are gone")

    with pytest.raises(MeasureError, match="of 2 observers 0 were left"):
        await lose_them()


# --- what is no fault ----------------------------------------------------------------------------


@pytest.mark.full
async def test_nothing_of_an_old_turn_moves_the_robot() -> None:
    """Left, expired, vanished, crashed, reconnected: after the stop no old turn moves the robot."""
    rows = await hand_over(6, load=LIGHT)
    assert rows[0].met, rows[0]
    assert min(rows[0].detail[ending] for ending in get_args(Ending)) >= 1


@pytest.mark.full
async def test_a_bad_link_is_measured() -> None:
    """The link is as bad as configured, and the robot still drives nearly all the time."""
    (found,) = await nuisance(10, at_once=1)
    assert found.detail["stops"] <= 1
    assert found.detail["one_way_ms"] >= 30
