"""Session by session: what the dialect `frames` takes for an answer, and for how long."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING

import pytest
from tests.robot.test_dialects import Robot, connected, framed, going, says

from wax.config.settings import RobotSettings
from wax.driver.interface import Pose
from wax.robot.serial.frames import NO_SESSION, DriveBody, HelloBody, StopBody
from wax.robot.serial.frames_dialect import FramesDialect
from wax.robot.serial.odometry import Odometry
from wax.robot.serial.wheels import WheelMixer

if TYPE_CHECKING:
    from collections.abc import Callable


def test_before_the_first_hello_nothing_is_known() -> None:
    """A line that was never opened does not answer, and nothing is known of its robot."""
    dialect = framed()
    assert not dialect.answers(0.0)
    assert dialect.overdue(0.5)
    assert dialect.moving is None
    assert dialect.known() == {"line_errors": 0.0}


def test_greetings_are_of_no_turn_and_of_no_time() -> None:
    """Hello and stop carry turn 0 and no time-to-live, and hello no time, whatever was reported."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    robot.answer(dialect, 1.0, time_ms=5000, sequence=99)  # the robot speaks; it did not hear
    robot.hear(dialect.data_to_send(going(1, 0), 3.0)[0])
    assert [type(frame.body) for frame in robot.heard] == [HelloBody, StopBody, HelloBody, StopBody]
    assert {(frame.turn, frame.ttl_ms) for frame in robot.heard} == {(0, 0)}
    assert [frame.time_ms for frame in robot.heard] == [0, 0, 0, 7000]


@pytest.mark.parametrize(("answered_s", "number"), [(1.1, 99), (1.5, 2)])
def test_what_is_no_answer_changes_nothing(answered_s: float, number: int) -> None:
    """The same session is offered on and on, until one of its frames is taken soon enough."""
    dialect, robot = framed(), Robot()
    hello = robot.hear(dialect.hello(1.0))
    robot.answer(dialect, answered_s, sequence=number)
    for now_s in (1.5, 1.625, 1.75):
        assert robot.hear(dialect.data_to_send(going(1, 0), now_s)[0]) == hello
    robot.answer(dialect, 1.75)
    assert robot.hear(dialect.data_to_send(going(1, 0), 1.76)[0]) == [DriveBody(600, 600)]


def test_a_frame_of_the_last_session_is_no_answer() -> None:
    """Nothing that was sent before the newest hello counts after it."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    before = robot.heard[-1].sequence
    robot.hear(dialect.hello(1.1))
    robot.answer(dialect, 1.1, sequence=before)
    assert not dialect.answers(1.1)
    robot.answer(dialect, 1.1)
    assert dialect.answers(1.1)


def test_a_robot_that_goes_on_answering_keeps_its_session() -> None:
    """Each answer is worth half a second from when the frame that it names was sent."""
    dialect, robot = connected(1.0)
    session = robot.decoder.session
    for number in range(1, 21):
        robot.hear(dialect.data_to_send(going(1, 0), 1.0 + number / 10)[0])
        robot.answer(dialect, 1.05 + number / 10)
    assert robot.decoder.session == session
    assert (dialect.answers(3.49), dialect.answers(3.5)) == (True, False)
    assert (dialect.overdue(3.49), dialect.overdue(3.5)) == (False, True)


def test_a_robot_that_lags_behind_is_not_heard() -> None:
    """What it names must be among the last 256 frames, however soon they came."""
    for behind, hears in ((255, True), (256, False)):
        dialect, robot = connected(1.0)
        for number in range(300):
            robot.hear(dialect.data_to_send(going(1 if number % 2 else -1, 0), 1.4)[0])
        robot.answer(dialect, 1.4, sequence=robot.heard[-1].sequence - behind)
        assert dialect.answers(1.5) is hears


def test_after_a_silence_the_motion_is_said_at_once() -> None:
    """With a new session's first answer nothing counts as said, not even the same order."""
    dialect, robot = connected(1.0)
    robot.hear(dialect.data_to_send(going(1, 0), 1.0)[0])
    robot.hear(dialect.data_to_send(going(1, 0), 1.5)[0])
    robot.answer(dialect, 1.51)
    assert robot.hear(dialect.data_to_send(going(1, 0), 1.52)[0]) == [DriveBody(600, 600)]


def test_a_turn_that_begins_with_motion_begins_with_a_stop() -> None:
    """Where the stop between two turns was never said it is said first; elsewhere there is one."""
    dialect, robot = connected(1.0)
    robot.hear(dialect.data_to_send(going(1, 0), 1.0)[0])
    assert robot.hear(dialect.data_to_send(going(-1, 0, turn=2), 1.01)[0]) == [
        StopBody(),
        DriveBody(-600, -600),
    ]
    assert robot.heard[-2].turn == 2
    assert robot.hear(dialect.data_to_send(going(0, 0, turn=3), 1.02)[0]) == [StopBody()]
    assert robot.hear(dialect.data_to_send(going(1, 0, turn=3), 1.03)[0]) == [DriveBody(600, 600)]


def test_a_robot_that_stopped_by_itself_does_not_go_on_by_itself() -> None:
    """When its own watchdog has stopped it, a new session begins, although it answers."""
    dialect, robot = connected(1.0)
    session = robot.decoder.session
    robot.hear(dialect.data_to_send(going(1, 0), 1.0)[0])
    robot.answer(dialect, 1.2, flags=2)
    assert not dialect.answers(1.2)
    assert dialect.overdue(1.2)
    assert [type(body) for body in robot.hear(dialect.data_to_send(going(1, 0), 1.21)[0])] == [
        HelloBody,
        StopBody,
    ]
    assert robot.decoder.session != session
    robot.answer(dialect, 1.22)
    assert dialect.answers(1.22)


def test_a_stop_of_its_own_before_the_session_is_no_news() -> None:
    """A robot may begin with the report that its watchdog had stopped it; that session is over."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    robot.answer(dialect, 1.1, flags=2)
    assert dialect.answers(1.1)


def test_ticks_of_known_length_tell_where_it_is() -> None:
    """By the robot's own clock, past its end too; a new session begins where the last one ended."""
    settings = RobotSettings.model_validate({"serial": {"ticks_per_m": 1000.0}})
    dialect = FramesDialect(WheelMixer(settings), 200, (), Odometry(settings))
    robot = Robot()
    robot.hear(dialect.hello(1.0))
    robot.answer(dialect, 1.0, time_ms=2**32 - 100)
    assert dialect.pose is None
    assert "left_mps" not in dialect.known()
    robot.answer(dialect, 9.0, time_ms=100, left_ticks=100, right_ticks=100)
    assert dialect.pose == Pose(0.1, 0.0, 0.0)
    assert dialect.known()["left_mps"] == pytest.approx(0.5)
    robot.hear(dialect.hello(10.0))
    assert dialect.pose is None
    robot.answer(dialect, 10.0, time_ms=5, left_ticks=7, right_ticks=7)
    robot.answer(dialect, 10.1, time_ms=105, left_ticks=107, right_ticks=107)
    assert dialect.pose == Pose(0.2, 0.0, 0.0)


def test_farewell_before_any_motion() -> None:
    """Where no turn has begun the last stop is of turn 0."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    assert robot.hear(dialect.farewell()) == [StopBody()]
    assert robot.heard[-1].turn == 0


def test_while_it_does_not_answer_the_next_greeting_is_waited_for() -> None:
    """However long that lasts, hello and stop come ten times a second and no more often."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    robot.hear(dialect.data_to_send(going(1, 0), 2.0)[0])
    assert says(dialect, going(-1, 0), 2.05) == (b"", 2.1)


@pytest.fixture
def draws(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], list[int]]:
    """Let chance give always the same number; tells from how many it was drawn."""
    drawn_from: list[int] = []

    def rig(number: int) -> list[int]:
        def draw(below: int) -> int:
            drawn_from.append(below)
            return number

        monkeypatch.setattr(secrets, "randbelow", draw)
        return drawn_from

    return rig


def test_sessions_are_drawn_from_all_that_there_are(draws: Callable[[int], list[int]]) -> None:
    """1 to 65533, and 65534 in the place of the one that was just drawn."""
    drawn_from = draws(0)
    dialect, robot = framed(), Robot()
    sessions = [robot.hear(dialect.hello(float(n)))[0] for n in range(3)]
    assert sessions == [HelloBody(1), HelloBody(65_534), HelloBody(1)]
    assert set(drawn_from) == {65_533}
    draws(65_532)
    assert robot.hear(dialect.hello(9.0))[0] == HelloBody(65_533)
    assert NO_SESSION == 65_535
