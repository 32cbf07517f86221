"""Any driver, observed in its process: its calls, and whether its robot moves."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import pytest
from tests.until import until

from wax.clock import SystemClock
from wax.commands.proof.measure import measure
from wax.commands.proof.observed import ObservedMotion, ObservedRobot
from wax.commands.proof.observer import Observer
from wax.config.robot import RobotSettings
from wax.config.settings import parse
from wax.driver.interface import STANDSTILL, Pose, RobotState, Twist
from wax.errors import DriverError
from wax.robot import steady

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

AHEAD = Twist(0.2, 0.0)


def at(x_m: float = 0.0, y_m: float = 0.0, heading_rad: float = 0.0) -> RobotState:
    return RobotState(connected=True, pose=Pose(x_m, y_m, heading_rad))


def test_a_robot_that_says_so_is_believed() -> None:
    """A robot that reports whether it moves is believed, whatever its pose."""
    motion = ObservedMotion()
    for moves in (True, False):
        state = RobotState(connected=True, moving=moves, pose=Pose(time.monotonic(), 0.0, 0.0))
        assert motion.seen(state) is moves


def test_a_pose_that_changes_is_motion() -> None:
    """A change of position or heading, even a slow one or across ±π, is motion; noise is not."""
    motion = ObservedMotion()
    assert motion.seen(at()) is False
    assert motion.seen(at(x_m=0.004)) is True
    assert motion.seen(at(x_m=0.004)) is False
    assert motion.seen(at(x_m=0.0041)) is False
    assert motion.seen(at(x_m=0.0041, heading_rad=0.01)) is True
    assert motion.seen(at(x_m=0.0041, heading_rad=0.01 + math.tau)) is False
    crept = [motion.seen(at(x_m=0.0041 + step * 2e-4, heading_rad=0.01)) for step in range(20)]
    assert crept.count(True) >= 5


def test_a_robot_that_tells_nothing_is_not_judged() -> None:
    """Without reports of motion or pose, whether it moves is unknown."""
    assert ObservedMotion().seen(RobotState(connected=True)) is None


class Watched:
    """A host's own robot, and the proof's observer."""

    def __init__(self, name: str) -> None:
        self.settings = parse(
            {"robot": {"driver": f"tests.commands.proof.robots:{name}"}}, "the host"
        )
        self.observer = Observer(self.settings.robot.driver)
        self.observer.open()
        self._table: dict[str, Any] = {
            "robot": self.settings.robot.model_dump_json(),
            "log": str(self.observer._log),
        }

    def build(self) -> ObservedRobot:
        driver = "wax.commands.proof.observed:ObservedRobot"
        settings = RobotSettings.model_validate({"driver": driver, "observed": self._table})
        return ObservedRobot(settings, SystemClock())


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], Watched]]:
    monkeypatch.setattr(steady, "TTL_S", 60.0)  # a busy machine is not what these are about
    made: list[Watched] = []

    def make(name: str) -> Watched:
        made.append(Watched(name))
        return made[-1]

    yield make
    for one in made:
        folder = one.observer._folder
        if folder is not None:
            folder.cleanup()


def drives(robot: ObservedRobot, moves: Callable[[], bool]) -> bool:
    """Request motion until the robot moves, since a machine may be too busy."""
    robot.state()
    if not moves():
        robot.apply(STANDSTILL, 1)
        robot.apply(AHEAD, 1)
    return moves()


def look(robot: ObservedRobot, for_s: float) -> None:
    """Poll the robot's state as the driver's process does."""
    end_s = time.monotonic() + for_s
    while time.monotonic() < end_s:
        robot.state()
        time.sleep(0.01)


def test_it_is_the_hosts_own_driver(watched: Callable[[str], Watched]) -> None:
    """Kind and limits are the host's driver's, and building it creates no file."""
    one = watched("Moving")
    robot = one.build()
    assert robot.kind == "tests.commands.proof.robots:Moving"
    assert robot.limits.linear_mps == 0.6
    robot.close()
    assert not one.observer._log.exists()


@pytest.mark.system
@pytest.mark.parametrize(("name", "least_ms"), [("Moving", 20.0), ("Posing", 0.0)])
async def test_what_it_is_told_and_how_long_it_moves_is_seen(
    watched: Callable[[str], Watched], name: str, least_ms: float
) -> None:
    """A stop, and the report of standstill after it, are events at their times."""
    one = watched(name)
    robot = one.build()
    robot.open()
    until(lambda: robot.state().connected)
    until(lambda: drives(robot, one.observer.moves))
    assert one.observer.missing() is None
    one.observer.forget()
    for _ in range(10):
        robot.apply(AHEAD, 1)
        look(robot, 0.01)
    fault_s = time.monotonic()
    robot.stop(1)
    until(lambda: (robot.state(), not one.observer.moves())[1])
    look(robot, 0.1)
    took_ms = (time.monotonic() - fault_s) * 1000.0
    sample = measure(one.observer.events(), fault_s)
    assert sample.speed_mps == pytest.approx(0.2)
    assert sample.frame_ms is not None
    assert sample.standing_ms is not None
    assert 0.0 <= sample.frame_ms < took_ms
    assert least_ms <= sample.standing_ms < took_ms
    assert not one.observer.moves()
    robot.close()
    await one.observer.ended()


@pytest.mark.system
async def test_its_speed_is_that_of_its_fastest_part(watched: Callable[[str], Watched]) -> None:
    """Ahead and sideways are one vector; what the turn adds at a wheel comes on top."""
    one = watched("Moving")
    robot = one.build()
    robot.open()
    robot.apply(Twist(0.3, 2.0, -0.4), 1)
    (said,) = [event for event in one.observer.events() if event.who == "said"]
    assert said.speed_mps == pytest.approx(0.5 + RobotSettings().wheel_base_m)
    robot.close()
    await one.observer.ended()


@pytest.mark.system
async def test_a_robot_is_watched_until_it_stands_before_it_is_released(
    watched: Callable[[str], Watched],
) -> None:
    """A process whose server is gone stops its robot, and its log ends with the standstill."""
    one = watched("Moving")
    robot = one.build()
    robot.open()
    until(lambda: robot.state().connected)
    until(lambda: drives(robot, lambda: robot.state().moving is True))
    robot.stop(1)
    start_s = time.monotonic()
    robot.close()
    assert time.monotonic() - start_s < 0.9
    told = [event.moves for event in one.observer.events() if event.who == "told"]
    assert True in told
    assert told[-1] is False
    await one.observer.ended()
    assert one.observer.events() == one.observer.events()


@pytest.mark.system
async def test_a_robot_that_reports_no_motion_is_named_as_such(
    watched: Callable[[str], Watched],
) -> None:
    """A robot that reports no motion gives a sentence about what its driver lacks."""
    one = watched("Blind")
    assert "has reported nothing" in str(one.observer.missing())
    robot = one.build()
    robot.open()
    until(lambda: robot.state().connected)
    robot.state()
    assert "neither moving nor pose" in str(one.observer.missing())
    robot.close()
    await one.observer.ended()


def test_what_cannot_be_cut_is_not_cut(watched: Callable[[str], Watched]) -> None:
    """The two links on the robot's side are skipped with a reason, and never cut."""
    observer = watched("Moving").observer
    assert set(observer.skips) == {"driver", "cut"}
    for act in (observer.cut, observer.mend):
        with pytest.raises(DriverError):
            act()


def test_a_line_that_is_half_written_waits(watched: Callable[[str], Watched]) -> None:
    """An incomplete line of the log is read once it is complete."""
    observer = watched("Moving").observer
    with observer._log.open("w") as log:
        log.write('[1.0, "said", true, 0.2]\n[2.0, "said", fal')
        log.flush()
        assert len(observer.events()) == 1
        log.write("se, 0.0]\n")
        log.flush()
        assert [event.moves for event in observer.events()] == [True, False]
