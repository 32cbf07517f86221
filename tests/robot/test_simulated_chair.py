"""The simulated robot with a person aboard."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest

from wax.clock import SystemClock
from wax.config.local import ActSettings, LocalSettings
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.process.driver_watchdog import NEUTRAL_FIRST
from wax.robot.simulated.chair import SimulatedChair
from wax.robot.simulated.person import ScriptedPerson

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.driver.interface import RobotState

PATIENCE_S = 30.0
AHEAD = Twist(0.3, 0.0)

SCRIPT = [
    ActSettings(at_s=1.0, for_s=0.5, linear=-1.0),
    ActSettings(at_s=2.0, for_s=0.5, angular=0.5, lateral=-0.5),
    ActSettings(at_s=3.0, for_s=0.5, press="wait"),
    ActSettings(at_s=4.0, press="stop"),
    ActSettings(at_s=4.2, for_s=0.1, press="go_on"),
]


def test_the_person_follows_the_script_again_and_again() -> None:
    """Each act lasts as configured, the later of two counts, and the script repeats."""
    person = ScriptedPerson(LocalSettings(source="robot", script=SCRIPT, script_s=10.0), 100.0)
    for round_s in (100.0, 110.0, 150.0):
        assert person.reading(round_s + 0.99).linear == 0.0
        assert person.reading(round_s + 1.01).linear == -1.0
        assert person.reading(round_s + 1.51).linear == 0.0
        aside = person.reading(round_s + 2.25)
        assert (aside.linear, aside.angular, aside.lateral) == (0.0, 0.5, -0.5)
        assert person.reading(round_s + 3.25).ask == "wait"
        assert person.reading(round_s + 4.1).stop
        assert person.reading(round_s + 4.25).ask == "go_on"
        assert person.reading(round_s + 4.4).stop
        assert not person.reading(round_s + 5.0).stop


@pytest.fixture
def chair(request: pytest.FixtureRequest) -> Iterator[SimulatedChair]:
    """Return a chair for which a server is silent after so many milliseconds."""
    script = [ActSettings(at_s=1.5, for_s=1.0, linear=-1.0)]
    # The script repeats: a busy machine may miss an act.
    local = LocalSettings(source="robot", pause_s=0.5, script=script, script_s=6.0)
    chair = SimulatedChair(RobotSettings(silence_ms=request.param), local, SystemClock())
    yield chair
    chair.close()


def until(chair: SimulatedChair, twist: Twist, so: Callable[[RobotState], bool]) -> None:
    """Send a twist, as the control loop does, until `so` holds for the chair."""
    end_s = time.monotonic() + PATIENCE_S
    while not so(chair.state()):
        assert time.monotonic() < end_s
        chair.apply(twist, 1)
        time.sleep(0.01)


def mode(state: RobotState) -> str:
    return "none" if state.aboard is None else state.aboard.mode


@pytest.mark.system
@pytest.mark.parametrize("chair", [1000], indirect=True)
def test_the_person_takes_over_and_lets_go(chair: SimulatedChair) -> None:
    """They drive back against an operator who asks for ahead and then must begin from neutral."""
    assert mode(chair.state()) == "lost"
    chair.open()
    until(chair, STANDSTILL, lambda now: mode(now) == "free")
    chair.apply(STANDSTILL, 1)
    until(chair, AHEAD, lambda now: now.extra["speed_mps"] > 0.1)
    until(chair, AHEAD, lambda now: mode(now) == "hand")
    until(chair, AHEAD, lambda now: now.extra["speed_mps"] < -0.1)
    until(chair, AHEAD, lambda now: mode(now) == "free")
    until(chair, AHEAD, lambda now: now.problem == NEUTRAL_FIRST)
    assert chair.state().extra["speed_mps"] == 0.0
    until(chair, STANDSTILL, lambda now: now.problem is None)
    until(chair, AHEAD, lambda now: now.extra["speed_mps"] > 0.1)


@pytest.mark.system
@pytest.mark.parametrize("chair", [120], indirect=True)
def test_a_silent_server_stops_the_operators_driving(chair: SimulatedChair) -> None:
    """The simulated robot keeps the driver process's rules with somebody aboard, too."""
    chair.open()
    until(chair, STANDSTILL, lambda now: mode(now) == "free")
    end_s = time.monotonic() + PATIENCE_S
    while (before := chair.state()).problem is not None or before.extra["speed_mps"] < 0.1:
        assert time.monotonic() < end_s
        # A busy machine may have exceeded the timeout already.
        chair.apply(AHEAD if before.problem is None else STANDSTILL, 1)
        time.sleep(0.01)
    while (after := chair.state()).problem is None:
        assert time.monotonic() < end_s
        time.sleep(0.01)
    assert after.extra["driver_silences"] == before.extra["driver_silences"] + 1.0
