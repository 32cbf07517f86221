"""The faults suite, short: the stop comes in time, and is late if a watchdog is slow."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, get_args

import pytest

from e2e.harness.wait import eventually
from e2e.measure.errors import MeasureError
from e2e.measure.table import to_table
from e2e.stop.black_channel import CELLS, black_channel
from e2e.stop.blind import camera_freezes, page_starves, video_starves
from e2e.stop.delay_step import delay_step
from e2e.stop.flood import WAYS, stop_in_flood
from e2e.stop.hand import hand_touched, hand_touched_server_stopped
from e2e.stop.hand_over import Ending, hand_over, one_turn
from e2e.stop.hands_off import hands_off
from e2e.stop.nuisance import TTLS_MS, nuisance
from e2e.stop.operator_gone import browser_frozen, browser_killed, network_vanishes
from e2e.stop.robot_gone import driver_killed, serial_unplugged
from e2e.stop.server_gone import loop_blocked, server_killed, server_stopped
from e2e.stop.stage import DEFAULT, LIGHT, staged
from e2e.stop.steady_beat import steady_beat

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from e2e.measure.row import Row

TRIALS = 2
_TICK_S = 0.01
_DEAF = """
for (const type of ["blur", "visibilitychange"])
    addEventListener(type, (event) => event.stopImmediatePropagation(), true);
"""
"""The page's own listeners never hear that its window has lost the keyboard or is hidden."""

pytestmark = pytest.mark.timeout(90)


class Lateness:
    """The longest delay of a 10 ms timer on this machine, which is not the robot's fault."""

    worst_s = 0.0

    async def watch(self) -> None:
        while True:
            before_s = time.monotonic()
            await asyncio.sleep(_TICK_S)
            self.worst_s = max(self.worst_s, time.monotonic() - before_s - _TICK_S)


@asynccontextmanager
async def lateness() -> AsyncIterator[Lateness]:
    machine = Lateness()
    watching = asyncio.create_task(machine.watch())
    try:
        yield machine
    finally:
        watching.cancel()


async def keeps(found: Awaitable[Row | list[Row]]) -> None:
    """Assert that every goal is met; a failure says how late the machine itself was."""
    async with lateness() as machine:
        result = await found
    rows = result if isinstance(result, list) else [result]
    missed = [row for row in rows if not row.met]
    assert not missed, (
        f"{to_table(missed)}\nThis machine was late by {machine.worst_s * 1000:.0f} ms itself."
    )


async def test_a_network_that_vanishes_stops_the_robot() -> None:
    """At full speed it is told to stand 200 ms after the last packet, and does within 0.3 m."""
    await keeps(network_vanishes(TRIALS, load=LIGHT))


@pytest.mark.parametrize(
    "measure",
    [browser_frozen, pytest.param(browser_killed, marks=pytest.mark.full)],
    ids=lambda one: str(one.__name__),
)
async def test_a_dead_browser_stops_the_robot(measure: Callable[..., Awaitable[Row]]) -> None:
    """The robot is told to stand 200 ms after its operator's browser died, key held down."""
    await keeps(measure(TRIALS, load=LIGHT))


@pytest.mark.full
async def test_a_line_that_becomes_long_stops_the_robot() -> None:
    """Late commands move nothing, although they keep arriving."""
    await keeps(delay_step(TRIALS, load=LIGHT))


@pytest.mark.full
async def test_a_blocked_server_stops_the_robot() -> None:
    """The process that speaks with the robot does, and nothing late moves it afterwards."""
    await keeps(loop_blocked(TRIALS, load=LIGHT))


@pytest.mark.full
async def test_nothing_of_an_old_turn_moves_the_robot() -> None:
    """Left, over, vanished, crashed or come back: a stop, and nothing of the old turn after it."""
    late, without_stop, _ = await hand_over(6, load=LIGHT)
    assert (late.met, without_stop.met) == (True, True), f"{late}\n{without_stop}"
    assert min(late.detail[ending] for ending in get_args(Ending)) >= 1


@pytest.mark.full
async def test_a_turn_lasts_as_long_as_is_said() -> None:
    """From the first frame of a turn to the first of the next, to a tenth of a second."""
    await keeps(one_turn(1, turn_s=3.0, load=LIGHT))


@pytest.mark.full
async def test_a_bad_link_is_measured() -> None:
    """The link is as bad as it shall be, and over it the robot drives nearly all the time."""
    found = await nuisance(10, load=LIGHT)
    assert (found.n >= 10, found.goal) == (True, 1.0)
    assert found.detail["stops"] <= 1
    assert found.detail["one_way_ms"] >= 30
    curve = found.detail["stops_in_ten_minutes_by_time_to_live"]
    assert list(curve) == [f"{ttl_ms} ms" for ttl_ms in TTLS_MS]


@pytest.mark.full
async def test_the_beat_is_measured_where_it_is_made() -> None:
    """Of the frames and of the loop there is a row each for jitter and gap, under some load."""
    load = replace(DEFAULT, observers=4)
    found = {row.key: row for row in await steady_beat(250, load=load)}
    assert {key: row.goal for key, row in found.items()} == {
        "steady-beat: jitter": 5.0,
        "steady-beat: gap": 40.0,
        "steady-beat: loop's jitter": 5.0,
        "steady-beat: loop's gap": 40.0,
    }
    assert min(row.n for row in found.values()) >= 225
    assert found["steady-beat: gap"].values["median"] == pytest.approx(20, abs=5)
    assert (found["steady-beat: loop's gap"].values["max"] or 0.0) >= 20


@pytest.mark.full
async def test_a_load_that_did_not_hold_is_no_result() -> None:
    """Where observers are gone at the end, nothing that was measured counts."""

    async def lose_them() -> None:
        async with staged(load=replace(DEFAULT, observers=2)) as stage:
            assert stage.crowd is not None
            await asyncio.to_thread(stage.crowd.hold, 0)

            async def forgotten() -> bool:
                return not (await stage.server.status())["viewers"]

            await eventually(forgotten, "the observers are forgotten")

    with pytest.raises(MeasureError, match="of 2 observers 0 were left"):
        await lose_them()


@pytest.mark.full
async def test_no_harm_to_a_channel_is_executed() -> None:
    """Each of the eight errors to drive, stop and release, once: none does what it must not."""
    await keeps(black_channel(len(CELLS), load=LIGHT))


@pytest.mark.parametrize(
    "measure",
    [pytest.param(server_killed, marks=pytest.mark.full), server_stopped, driver_killed],
    ids=lambda one: str(one.__name__),
)
async def test_a_dead_process_stops_the_robot(measure: Callable[..., Awaitable[Row]]) -> None:
    """The robot stands soon after a process next to it is gone, and nothing late moves it."""
    await keeps(measure(TRIALS, load=LIGHT))


@pytest.mark.parametrize(
    "measure", [hand_touched, pytest.param(hand_touched_server_stopped, marks=pytest.mark.full)]
)
async def test_a_hand_aboard_takes_the_robot_from_its_operator(
    measure: Callable[..., Awaitable[list[Row]]],
) -> None:
    """At once, and the person drives, whether the server runs or is frozen."""
    await keeps(measure(TRIALS, load=LIGHT))


async def test_an_unplugged_line_stops_the_robot() -> None:
    """The board stops on its own, the page says so, and driving again needs a new press."""
    await keeps(serial_unplugged(1, load=LIGHT))


@pytest.mark.full
async def test_stop_is_heard_in_a_flood() -> None:
    """Stop gets through a flood in each way, pressed by operator, observer or the flooder.

    The flood is one that a shared machine can carry; in one that no server can, the flooder's own
    Stop waits behind their other messages.
    """
    await keeps(stop_in_flood(len(WAYS), rate_hz=3000.0, load=LIGHT))


@pytest.mark.full
async def test_hands_off_is_zero_on_the_wire() -> None:
    """Another tab, a minimised window, a navigation, a cancelled touch: zero within 120 ms."""
    await keeps(hands_off(1, load=LIGHT))


@pytest.mark.full
async def test_who_does_not_see_does_not_drive() -> None:
    """A picture that does not come slows the robot and then stops it."""
    await keeps(video_starves(1, load=LIGHT))
    await keeps(page_starves(1, load=LIGHT))
    await keeps(camera_freezes(1, load=LIGHT))


@pytest.mark.full
async def test_a_page_that_holds_on_does_not_stop() -> None:
    """The page's measurement fails if the page does not get the event."""
    deaf, touch = await hands_off(1, acts=["another tab"], script=_DEAF, load=LIGHT)
    assert (deaf.met, touch.met) == (False, True)


@pytest.mark.full
async def test_without_the_watchdog_of_silence_the_stop_is_late() -> None:
    """A slow driver's process and board are noticed: the measure of a stopped server can fail."""
    slow = {"silence_ms": 1000, "serial": {"ttl_ms": 1000}}
    assert not (await server_stopped(1, robot=slow, load=LIGHT)).met


@pytest.mark.full
async def test_without_the_driver_process_s_silence_the_stop_is_late() -> None:
    """With a quick board still there, each of the two watchdogs is noticed separately."""
    assert not (await server_stopped(1, robot={"silence_ms": 1000}, load=LIGHT)).met


@pytest.mark.full
async def test_without_the_board_s_own_watchdog_the_stop_is_late() -> None:
    """A board that obeys old frames is noticed: the measure of a killed driver can fail."""
    slow = {"silence_ms": 120, "serial": {"ttl_ms": 1000}}
    assert not (await driver_killed(1, robot=slow, load=LIGHT)).met


@pytest.mark.full
async def test_without_the_age_of_a_command_the_stop_is_late() -> None:
    """A gate that obeys old commands is noticed: the measure of a vanished network can fail."""
    slow = {"max_age_ms": 1000.0, "max_command_age_ms": 2000.0}
    late, far = await network_vanishes(1, drive=slow, load=LIGHT)
    assert (late.met, far.met) == (False, False)


@pytest.mark.full
async def test_without_the_age_of_a_command_a_delay_is_executed() -> None:
    """A gate that obeys old commands is noticed: the measure of the black channel can fail."""
    slow = {"max_age_ms": 1000.0, "max_command_age_ms": 2000.0}
    (found,) = await black_channel(20, cells=[("delay", "drive")], drive=slow, load=LIGHT)
    assert (found.met, list(found.detail["wrong_by_error"])) == (False, ["drive: delay"])
