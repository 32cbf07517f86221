"""The suite: breaks each link from finger to wheel while the robot drives, and times the stop."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.row import Row
from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite
from e2e.stop.black_channel import black_channel
from e2e.stop.blind import camera_freezes, page_starves, video_starves
from e2e.stop.delay_step import delay_step
from e2e.stop.flood import stop_in_flood
from e2e.stop.hand import hand_touched, hand_touched_server_stopped
from e2e.stop.hand_over import hand_over, one_turn
from e2e.stop.hands_off import hands_off
from e2e.stop.nuisance import nuisance
from e2e.stop.operator_gone import browser_frozen, browser_killed, network_vanishes
from e2e.stop.robot_gone import driver_killed, serial_unplugged
from e2e.stop.server_gone import loop_blocked, server_killed, server_stopped
from e2e.stop.stage import DEFAULT
from e2e.stop.steady_beat import steady_beat
from e2e.stop.traces import traces

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    Measure = Callable[[int], Coroutine[Any, Any, Row | list[Row]]]


def staged_case(key: str, n: int, measure: Measure, title: str, quick: int = 2) -> Case:
    """Make a case of a measurement on the stage under the default load."""

    def run(n: int) -> list[Row]:
        # A loop for each, so that leftovers of one do not disturb the next.
        found = asyncio.run(measure(n))
        rows = [found] if isinstance(found, Row) else found
        return [row.model_copy(update={"load": str(DEFAULT)}) for row in rows]

    return Case(key, title, n, run, quick)


SUITE: Final = Suite(
    name="faults",
    about="Break each link from finger to wheel while the robot drives; time the stop.",
    measures=(*SERVER, *PAGE, *FIRMWARE),
    columns=("median", "p99", "max"),
    cases=(
        Case("traces", "generated traces", 100_000, lambda n: asyncio.run(traces(n)), 1000),
        staged_case("network-vanishes", 200, network_vanishes, "operator's network, at full speed"),
        staged_case("browser-frozen", 200, browser_frozen, "SIGSTOP to the operator's browser"),
        staged_case("browser-killed", 200, browser_killed, "SIGKILL to the operator's browser"),
        staged_case("server-killed", 100, server_killed, "SIGKILL to the server"),
        staged_case("server-stopped", 100, server_stopped, "SIGSTOP to the server"),
        staged_case("loop-blocked", 100, loop_blocked, "the server's event loop, for 5 s"),
        staged_case("driver-killed", 100, driver_killed, "SIGKILL to the driver's process"),
        staged_case("serial-unplugged", 100, serial_unplugged, "the robot's serial line"),
        staged_case("delay-step", 50, delay_step, "from 20 to 1000 ms one way"),
        # A fifth of them are the flooder's own.
        staged_case("stop-in-flood", 250, stop_in_flood, "Stop while a viewer floods", 5),
        # A few turns are over before they moved.
        staged_case("hand-over", 1050, hand_over, "turns in which nothing old may move", 6),
        staged_case("one-turn", 3, one_turn, "whole turns", 1),
        staged_case("hand", 1000, hand_touched, "the person aboard touches their hand control"),
        staged_case(
            "hand-alone", 1000, hand_touched_server_stopped, "the same with the server stopped"
        ),
        staged_case("hands-off", 50, hands_off, "each way to take the hands off the page"),
        staged_case("blind-camera", 25, camera_freezes, "the camera freezes"),
        staged_case("blind-video", 25, video_starves, "no new picture comes"),
        staged_case("blind-page", 25, page_starves, "pictures are lost on their way to a page"),
        staged_case("nuisance", 600, nuisance, "seconds over a bad link, stops counted", 10),
        staged_case("steady-beat", 3000, steady_beat, "frames to the board, their beat", 250),
        staged_case("black-channel", 1000, black_channel, "harmed messages", 24),
    ),
)
