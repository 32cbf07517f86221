"""What is known of a rover, and why it is not driven."""

from __future__ import annotations

from typing import Any

import pytest

from wax.driver.interface import Pose
from wax.robot.mavlink.failsafe import QUESTIONS
from wax.robot.mavlink.news import (
    Attitude,
    Battery,
    HeardMessage,
    Heartbeat,
    News,
    Parameter,
    Position,
    Speed,
)
from wax.robot.mavlink.rover import (
    ASK_FOR_S,
    BATTERY_OLD_S,
    SILENT_S,
    TELEMETRY_SILENT_S,
    Rover,
)
from wax.robot.mavlink.settings import MavlinkSettings

BEAT = Heartbeat(10, 3, 15, is_armed=True)


def rover(*news: News, now_s: float = 100.0, **settings: Any) -> Rover:
    one = Rover(MavlinkSettings(url="udpin:a:1", **settings))
    one.begin(now_s)
    receive(one, *news, now_s=now_s)
    return one


def receive(
    one: Rover,
    *news: News | None,
    now_s: float = 100.0,
    system: int = 1,
    component: int = 1,
    signed: bool = False,
) -> list[bool]:
    return [
        one.handle_message(HeardMessage(system, component, piece, is_signed=signed), now_s)
        for piece in news
    ]


def code(sentence: Any) -> str:
    return "" if sentence is None else str(sentence.code)


def test_it_answers_as_long_as_heartbeats_come() -> None:
    """One lost heartbeat is tolerated; with telemetry, silence counts sooner."""
    one = rover(BEAT)
    assert one.answers(100.0 + SILENT_S - 0.01)
    assert not one.answers(100.0 + SILENT_S)
    receive(one, Speed(0.0))
    assert not one.answers(100.0 + TELEMETRY_SILENT_S)


def test_a_slow_radio_is_not_missed_too_soon() -> None:
    """At a low telemetry rate a longer silence is tolerated."""
    assert rover(BEAT, Speed(0.0), telemetry_hz=2.0).answers(101.9)


def test_before_it_is_heard_the_problem_changes_with_time() -> None:
    """At first it is listening, then silent; another system is named."""
    one = rover()
    assert code(one.absent(100.0, 0)) == "mavlink.listening"
    assert code(one.absent(100.0 + SILENT_S, 0)) == "mavlink.silent"
    assert code(one.absent(100.0 + SILENT_S, 3)) == "mavlink.unsigned"
    receive(one, BEAT, system=7)
    assert code(one.absent(100.0 + SILENT_S, 0)) == "mavlink.other_system"


def test_parameters_are_requested_until_they_arrive_or_time_is_up() -> None:
    """Either of two names is enough; older firmware lacks some parameters."""
    one = rover(BEAT)
    assert set(one.unasked(100.0)) == {name for names in QUESTIONS for name in names}
    assert code(one.absent(100.0, 0)) == "mavlink.asking"
    receive(one, *(Parameter(names[-1], 255.0) for names in QUESTIONS))
    assert one.unasked(100.0) == ()
    assert one.absent(100.0, 0) is None
    older = rover(BEAT)
    assert older.unasked(100.0 + ASK_FOR_S) == ()


@pytest.mark.parametrize(
    ("beat", "expected"),
    [
        (BEAT, ""),
        (Heartbeat(11, 3, 15, is_armed=True), ""),
        (Heartbeat(2, 3, 15, is_armed=True), "mavlink.no_rover"),
        (Heartbeat(10, 12, 15, is_armed=True), "mavlink.no_rover"),
        (Heartbeat(10, 3, 0, is_armed=True), "mavlink.wrong_mode"),
        (Heartbeat(10, 3, 99, is_armed=True), "mavlink.wrong_mode"),
        (Heartbeat(10, 3, 15, is_armed=False), "mavlink.disarmed"),
    ],
)
def test_only_an_armed_rover_in_the_right_mode_is_driven(beat: Heartbeat, expected: str) -> None:
    """A boat counts as one; a copter or another autopilot, with another neutral, does not."""
    assert code(rover(beat).unfit()) == expected


def test_whoever_would_interfere_is_a_problem() -> None:
    """A ground station with our number, or a rover that signs or obeys another."""
    one = rover(BEAT)
    receive(one, Heartbeat(6, 8, 0, is_armed=False), system=255)
    assert code(one.unfit()) == "mavlink.twin"
    signed = rover()
    receive(signed, BEAT, signed=True)
    assert code(signed.unfit()) == "mavlink.signed"
    assert code(rover(BEAT, Parameter("SYSID_MYGCS", 1.0)).unfit()) == "mavlink.not_ours"


@pytest.mark.parametrize("component", [0, 2, 100, 191])
def test_only_the_autopilot_speaks_for_the_rover(component: int) -> None:
    """Other components with its number neither keep it connected nor change its state."""
    one = rover(BEAT, Attitude(0.0, 0.0, 60_000), Parameter("SYSID_MYGCS", 255.0))
    others = (
        None,
        Heartbeat(6, 8, 0, is_armed=False),
        Parameter("SYSID_MYGCS", 1.0),
        Speed(0.5),
        Attitude(0.0, 0.0, 500),
    )
    taken = receive(one, *others, now_s=100.0 + SILENT_S - 0.1, component=component, signed=True)
    assert taken == [False] * len(others)
    assert one.unfit() is None
    assert (one.restarted, one.moving) == (False, None)
    assert not one.answers(100.0 + SILENT_S)


def test_a_restart_is_noticed_by_the_time_since_power_on() -> None:
    """Only a large step back counts, as messages may be reordered."""
    one = rover(BEAT, Attitude(0.0, 0.0, 60_000), Attitude(0.0, 0.0, 59_900))
    assert not one.restarted
    receive(one, Attitude(None, None, 500))
    assert one.restarted


def test_it_moves_when_it_drives_or_turns() -> None:
    """A speed below the threshold is noise; no speed is unknown."""
    assert rover(BEAT).moving is None
    assert rover(BEAT, Speed(0.09)).moving is False
    assert rover(BEAT, Speed(0.1)).moving is True
    assert rover(BEAT, Speed(0.0), Attitude(0.0, -0.06, 1)).moving is True
    assert rover(BEAT, Speed(None), Attitude(None, -0.06, 1)).moving is True
    assert rover(BEAT, Speed(0.5), Speed(None), Attitude(0.0, 0.0, 1)).moving is None
    assert rover(BEAT, Speed(0.5), Attitude(0.0, None, 1)).moving is True


def test_pose_and_battery_are_what_it_told_last() -> None:
    """A missing battery value keeps the last, a missing heading ends the pose."""
    one = rover(BEAT, Battery(8.1, None), Battery(None, 0.5), Position(1.0, 2.0))
    assert one.pose is None
    receive(one, Attitude(0.5, 0.0, 1))
    assert one.pose == Pose(1.0, 2.0, 0.5)
    receive(one, Attitude(None, 0.0, 2))
    assert one.pose is None
    assert one.battery == Battery(8.1, 0.5)


def test_an_old_voltage_expires() -> None:
    """The last voltage of a battery monitor that has failed becomes unknown."""
    one = rover(BEAT, Battery(8.1, 0.5))
    receive(one, Battery(None, 0.4), now_s=100.0 + BATTERY_OLD_S)
    assert one.battery == Battery(None, 0.4)
