"""What is sent to the robot and reported of it, on a manual clock."""

from __future__ import annotations

from tests.robot.ros2.robots import ros2_settings

from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.ros2.conversation import Ros2Conversation
from wax.robot.ros2.settings import Ros2Settings
from wax.sentence import Sentence

AHEAD = Twist(0.3, 0.0)
OTHER = Sentence("ros2.other_publisher", {"topic": "/cmd_vel", "n": 1})


def conversation() -> Ros2Conversation:
    talk = Ros2Conversation(ros2_settings(0).own(Ros2Settings), Limits(0.6, 1.5))
    talk.opened(0.0)
    return talk


def said(talk: Ros2Conversation, start_s: float, for_s: float) -> list[Twist]:
    steps = range(round(for_s * 1000))
    told = (talk.next(start_s + step / 1000)[0] for step in steps)
    return [twist for twist in told if twist is not None]


def test_a_stop_is_sent_while_somebody_else_drives_the_robot() -> None:
    """Stop reaches the robot even while WAX does not drive it."""
    talk = conversation()
    talk.judged(None, alone=True)
    talk.apply(STANDSTILL, 1, 0.0)
    talk.apply(AHEAD, 1, 0.0)
    assert talk.next(0.0)[0] == AHEAD
    talk.judged(OTHER, alone=False)
    assert set(said(talk, 0.01, 5.0)) == {STANDSTILL}
    assert said(talk, 5.01, 60.0) == []
    talk.stop(1, 70.0)
    assert talk.owes(70.0)
    zeros = said(talk, 70.0, 10.0)
    assert set(zeros) == {STANDSTILL}
    assert len(zeros) in range(74, 77)
    assert not talk.owes(80.0)


def test_the_robots_timeout_is_reported_while_it_is_known() -> None:
    """The timeout is in the state, even if the robot may not be driven, until it is gone."""
    talk = conversation()
    assert talk.state(0.0).ttl_s is None
    talk.promised(0.5)
    assert (talk.state(0.0).ttl_s, talk.state(0.0).extra["ros2_timeout_s"]) == (0.5, 0.5)
    talk.judged(OTHER, alone=False)
    talk.promised(0.0)
    assert talk.state(0.0).ttl_s == 0.0
    talk.promised(None)
    assert talk.state(0.0).ttl_s is None
    assert "ros2_timeout_s" not in talk.state(0.0).extra
    talk.promised(0.5)
    talk.lost(None)
    assert talk.state(0.0).ttl_s is None
