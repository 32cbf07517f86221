"""What every driver on a line decides alike, on a clock that is turned by hand."""

from __future__ import annotations

from wax.driver.interface import STANDSTILL, Limits, Reading, Twist
from wax.robot.line.core import LineCore
from wax.sentence import Sentence

AHEAD = Twist(0.3, 0.0)
LOST = Sentence("robot.no_answer")


def connected() -> LineCore:
    core = LineCore(Limits(0.6, 1.5, axes=("pan",)), ttl_s=0.2)
    core.opened(0.0)
    core.heard(Reading(moving=False, extra={"volts": 7.4}))
    return core


def test_a_robot_is_connected_from_its_first_answer() -> None:
    """An open line alone is no robot; what it tells is shown while it is connected."""
    core = LineCore(Limits(0.6, 1.5), ttl_s=0.2)
    core.opened(0.0)
    assert not core.state(0.0).connected
    core.heard(Reading(moving=True, battery_v=7.4, gauges={"motor_c": 40.0}, extra={"steps": 1}))
    core.heard(None)
    state = core.state(0.0)
    assert (state.connected, state.epoch, state.moving) == (True, 1, True)
    assert (state.battery_v, state.gauges) == (7.4, {"motor_c": 40.0})
    core.lost(LOST)
    state = core.state(0.0)
    assert (state.connected, state.problem, state.moving, state.extra) == (False, LOST, None, {})


def test_an_answer_after_the_end_connects_nothing() -> None:
    """A call that hung while the line was closed may still return with an answer."""
    core = connected()
    core.lost(None)
    core.heard(Reading(moving=True))
    assert not core.state(0.0).connected
    core.apply(STANDSTILL, 1, 0.0)
    core.apply(AHEAD, 1, 0.0)
    assert core.order(0.0)[0].twist == STANDSTILL


def test_each_connection_begins_at_standstill() -> None:
    """A new connection is a new epoch, in which a held input moves nothing."""
    core = connected()
    core.apply(STANDSTILL, 1, 0.0)
    core.apply(AHEAD, 1, 0.0)
    assert core.order(0.0)[0].twist == AHEAD
    core.lost(LOST)
    core.opened(0.0)
    core.heard(None)
    core.apply(AHEAD, 1, 0.0)
    assert core.order(0.0)[0].twist == STANDSTILL
    assert (core.state(0.0).epoch, core.state(0.0).problem) == (2, None)


def test_a_stop_is_never_refused_and_an_axis_is_kept() -> None:
    """A stop of an earlier turn counts; a new connection forgets where the axes were."""
    core = connected()
    core.apply(STANDSTILL, 2, 0.0)
    core.apply(AHEAD, 2, 0.0)
    core.set_axis("pan", 0.5, 2)
    assert core.order(0.1)[0].axes == (("pan", 0.5),)
    core.stop(1, 0.1)
    assert core.order(0.1)[0].twist == STANDSTILL
    core.lost(None)
    assert core.order(0.1)[0].axes == ()


class Counting(LineCore):
    """Counts stops, as a protocol that repeats them does."""

    stops = 0

    def _stopped(self, now_s: float) -> None:
        self.stops += 1

    def _reading(self, now_s: float) -> Reading:
        return Reading(moving=True, extra={"stops": self.stops})


def test_what_a_protocol_counts_is_told_even_of_a_lost_robot() -> None:
    """Whether it moves is unknown then, but the errors on its line are not."""
    core = Counting(Limits(0.6, 1.5), ttl_s=0.2)
    core.stop(1, 0.0)
    state = core.state(0.0)
    assert (state.connected, state.moving, state.extra) == (False, None, {"stops": 1})
