"""The robot's controls in the control loop: when they are sent and released."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
from tests.control.rig import A, B, Bench, EquippedDriver, FakeDriver

from wax.config.controls import ControlSettings, GaugeSettings
from wax.control.controls import Operation
from wax.control.reasons import Hold, Refusal, stopped_by
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import RobotState
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Mapping


CONTROLS = [
    ControlSettings(name="lamp", kind="toggle", roles=["operator", "host", "observer"]),
    ControlSettings(name="horn", kind="button", roles=["operator", "host"]),
    ControlSettings(name="spin", kind="button", moves=True),
    ControlSettings(name="lift", kind="slider", moves=True),
    ControlSettings(name="light", kind="choice", choices=["white", "warm", "red"]),
]
HEAT = GaugeSettings(name="heat", label="Motors", stop_above=80.0)
COOL = RobotState(connected=True, epoch=1, gauges={"heat": 20.0})


class Rig(Bench):
    """An operator, an observer, and a robot that reports a temperature."""

    def __init__(self, driver: FakeDriver | None = None) -> None:
        super().__init__(driver=driver or EquippedDriver(), controls=CONTROLS, gauges=[HEAT])
        self.driver.now = COOL
        self.number = 0
        self.enter(A, B)
        self.step()
        assert self.offer() is None
        self.step()

    def ask(
        self,
        held: Mapping[str, float] | None = None,
        wanted: Mapping[str, float] | None = None,
        *,
        viewer: int = A,
        is_host: bool = False,
        turn: int | None = None,
    ) -> Refusal | None:
        self.number += 1
        asked = Operation(
            self.number,
            self.turns.number if turn is None else turn,
            self.clock.time_s,
            held or {},
            wanted or {},
            heard_s=self.clock.time_s,
        )
        return self.loop.operate(viewer, asked, is_host=is_host, one_way_s=0.1)

    def hold(self, *, still: bool = False) -> None:
        """Send a command that holds something, as a page does with each control."""
        command = replace(self.command(), held=not still)
        assert self.loop.handle_command(A, command) is None

    def told(self, after_s: float = 0.02) -> list[tuple[object, ...]]:
        """Run a step; return the driver's calls for controls and stops."""
        return [call for call in self.step(after_s) if call[0] in ("control", "stop")]

    def wait(self, seconds: float) -> list[tuple[object, ...]]:
        """Run steps for this time; return the driver's calls for controls and stops."""
        return [call for _ in range(round(seconds / 0.02)) for call in self.told()]

    def spin(self) -> None:
        """Hold a control that moves, and check that it moves."""
        self.hold()
        assert self.ask({"spin": 1}) is None
        self.step()
        assert self.loop._safe_driver._active["spin"].value is True


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_a_lamp_is_told_once_and_at_once(rig: Rig) -> None:
    """A lamp's value is sent at once, and not repeated at each tick."""
    rig.clock.time_s += 0.01
    rig.driver.take()
    assert rig.ask(wanted={"lamp": 1}) is None
    assert ("control", "lamp", True, 1) in rig.driver.take()
    assert rig.told() == []
    assert rig.ask(wanted={"lamp": 1}) is None
    assert rig.told() == []
    assert rig.loop.control_values == {"lamp": 1}
    assert rig.loop.counts()["controls.accepted"] == 2


def test_each_role_has_its_controls(rig: Rig) -> None:
    """Observers may use the lamp, the host the horn, and only the operator what moves."""
    assert rig.ask(wanted={"lamp": 1}, viewer=B) is None
    assert rig.ask({"horn": 1}, viewer=B) is Refusal.NOT_YOUR_TURN
    assert rig.ask({"horn": 1}, viewer=B, is_host=True) is None
    assert rig.ask({"spin": 1}, viewer=B, is_host=True) is Refusal.NOT_YOUR_TURN
    assert rig.ask({"spin": 1}, turn=0) is Refusal.OTHER_TURN
    assert rig.loop.counts()["controls.refused.not_your_turn"] == 2


def test_what_moves_needs_the_dead_man_of_driving(rig: Rig) -> None:
    """Without a command with the dead-man held, no control moves."""
    assert rig.ask({"spin": 1}) is None
    assert rig.told() == []
    rig.hold()
    assert rig.told() == [("control", "spin", True, 1)]
    rig.hold(still=True)
    assert rig.told() == [("control", "spin", False, 1)]


def test_what_moves_ends_with_the_commands(rig: Rig) -> None:
    """A moving control is released when commands cease, just as the wheels stop."""
    rig.hold()
    assert rig.ask({"lift": 0.5}) is None
    assert rig.told() == [("control", "lift", 0.5, 1)]
    assert rig.wait(0.22) == []
    assert rig.wait(0.04) == [("control", "lift", None, 1)]


def test_a_stop_lets_go_of_all_and_leaves_the_lamp_on(rig: Rig) -> None:
    """Moving controls end with the stop itself; horn and lamp may be used meanwhile."""
    rig.spin()
    assert rig.ask({"spin": 1, "horn": 1}, {"lamp": 1}) is None
    rig.step()
    rig.driver.take()
    stop = rig.loop.press_stop(says("Bob"))
    assert rig.driver.take() == [("stop", 1), ("control", "spin", False, 1)]
    assert ("control", "horn", False, 1) in rig.told()
    assert rig.ask({"spin": 1}) is Refusal.STOPPED
    assert rig.ask({"horn": 1}) is None
    assert rig.told() == []
    assert rig.ask() is None
    assert rig.ask({"horn": 1}) is None
    assert rig.told() == [("control", "horn", True, 1)]
    assert rig.loop.release_stop(A, stop, rig.clock.time_s) is None
    assert rig.ask({"spin": 1}) is None
    rig.hold()
    assert not any(call[:2] == ("control", "spin") for call in rig.told())


def test_after_a_stop_it_must_be_pressed_again(rig: Rig) -> None:
    """A moving control works again after everything was released and it was pressed again."""
    rig.spin()
    stop = rig.loop.press_stop(says("Bob"))
    assert rig.loop.release_stop(A, stop, rig.clock.time_s) is None
    rig.told()
    assert rig.ask({"spin": 1}) is None
    rig.hold(still=True)
    rig.told()
    rig.hold()
    assert rig.told() == []
    assert rig.ask() is None
    rig.spin()


def test_the_end_of_a_turn_lets_go(rig: Rig) -> None:
    """Moving controls are released with the stop between two turns, the horn right after it."""
    rig.spin()
    assert rig.ask({"spin": 1, "horn": 1}, {"lamp": 1}) is None
    rig.step()
    rig.driver.take()
    rig.loop.end_turn()
    assert ("control", "spin", False, 1) in rig.driver.take()
    assert ("control", "horn", False, 2) in rig.told()
    assert rig.ask({"spin": 1}) is Refusal.NOT_YOUR_TURN
    assert rig.loop.control_values == {"lamp": 1}


def test_a_lost_operator_moves_nothing(rig: Rig) -> None:
    """A control still held when the connection returns must be pressed again."""
    rig.spin()
    rig.driver.take()
    rig.loop.lost(A)
    assert rig.driver.take() == [("stop", 1), ("control", "spin", False, 1)]
    assert rig.told() == []


def test_a_robot_that_comes_back_gets_its_lamp_and_no_motion(rig: Rig) -> None:
    """After a reconnection set values are sent again and moving controls are released."""
    rig.spin()
    assert rig.ask({"spin": 1}, {"lamp": 1}) is None
    rig.step()
    rig.driver.now = replace(COOL, epoch=2)
    told = rig.told()
    assert told[:2] == [("stop", 1), ("control", "spin", False, 1)]
    assert told[-1] == ("control", "lamp", True, 1)
    assert ("control", "spin", True, 1) not in told


def test_a_control_that_fails_stops_the_robot(rig: Rig) -> None:
    """A driver that raises is stopped, and starts from neutral when it works again."""
    rig.drive()
    rig.driver.broken = {"control"}
    assert rig.ask(wanted={"lamp": 1}) is None
    rig.step()
    assert rig.statuses[-1][:3] == (A, False, NO_ANSWER)
    rig.driver.broken = set()
    assert not rig.moves()
    assert ("control", "lamp", True, 1) in rig.driver.calls or rig.loop._safe_driver._active
    rig.drive()


def test_a_driver_without_controls_is_asked_for_none() -> None:
    """A driver without controls gets no calls for them."""
    rig = Rig(FakeDriver())
    assert rig.ask(wanted={"lamp": 1}) is None
    assert rig.told() == []


def test_the_end_of_the_server_lets_go(rig: Rig) -> None:
    """Held controls are released before the driver is closed."""
    rig.spin()
    assert rig.ask({"spin": 1, "horn": 1}) is None
    rig.step()
    rig.driver.take()
    rig.loop.stop()
    assert rig.driver.take() == [
        ("stop", 1),
        ("control", "spin", False, 1),
        ("control", "horn", False, 1),
    ]


def test_a_page_that_connects_again_begins_anew(rig: Rig) -> None:
    """A new page numbers its operations from the start, and what the old one held is released."""
    assert rig.ask({"horn": 1}) is None
    rig.step()
    rig.number = 0
    assert rig.ask({"horn": 1}) is Refusal.OUT_OF_ORDER
    rig.loop.connect(A)
    assert ("control", "horn", False, 1) in rig.told()
    rig.number = 0
    assert rig.ask({"horn": 1}) is None


def test_a_host_who_goes_lets_go(rig: Rig) -> None:
    """What somebody held who does not drive is released as soon as their page is gone."""
    assert rig.ask({"horn": 1}, viewer=B, is_host=True) is None
    assert rig.told() == [("control", "horn", True, 1)]
    rig.loop.gone(B)
    assert rig.told() == [("control", "horn", False, 1)]


def test_whoever_honks_is_not_idle(rig: Rig) -> None:
    """Using a control counts as activity."""
    rig.clock.time_s += 5.0
    assert rig.ask({"horn": 1}) is None
    turn = rig.turns._turn
    assert turn is not None
    assert turn.acted_s == rig.clock.time_s


# --- gauges -------------------------------------------------------------------------------------


def test_a_number_beyond_its_limit_stops_the_robot(rig: Rig) -> None:
    """A gauge beyond its limit stops the robot with a reason, and then neutral must come first."""
    rig.drive()
    rig.driver.now = replace(COOL, gauges={"heat": 81.0})
    assert ("stop", 1) in rig.told()
    hot = Sentence("gauge.above", {"name": "Motors", "limit": 80.0, "unit": ""})
    assert rig.statuses[-1][:3] == (A, False, hot)
    rig.driver.now = COOL
    assert not rig.moves()
    rig.wait(2.1)
    assert rig.statuses[-1][:3] == (A, False, Hold.FAULT.value)
    assert not rig.moves()
    rig.drive()


def test_the_clock_of_a_turn_stands_still_while_a_gauge_keeps_it(rig: Rig) -> None:
    """While a gauge stops the robot the turn's clock pauses."""
    rig.driver.now = replace(COOL, gauges={})
    rig.step()
    rig.step()
    assert rig.turns.paused_left_s(rig.clock.time_s) is not None


def test_the_status_names_the_gauge_even_during_a_stop(rig: Rig) -> None:
    """The status names the gauge; the page learns of the stop from the room's state."""
    rig.driver.now = replace(COOL, gauges={"heat": 81.0})
    rig.step()
    rig.loop.press_stop(says("Bob"))
    rig.step()
    assert rig.loop.latched is not None
    assert rig.statuses[-1][2] != stopped_by(says("Bob"))


def test_what_is_operated_is_told_as_numbers() -> None:
    """What is set stays; what is held, until it is released; a choice is its number."""
    rig = Rig()
    assert rig.loop.operated == {}
    assert rig.ask({"horn": 1.0}, {"light": 2.0}) is None
    rig.step()
    assert rig.loop.operated == {"horn": 1.0, "light": 2.0}
    assert rig.ask({}) is None
    rig.step()
    assert rig.loop.operated == {"light": 2.0}
