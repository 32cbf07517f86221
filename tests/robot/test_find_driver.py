"""Finding the driver that the configuration names."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import pytest
from structlog.testing import capture_logs
from tests.examples import at_length

from wax.clock import SystemClock
from wax.config.controls import ControlSettings
from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.driver.checks import within
from wax.driver.interface import HasCamera, HasMicrophone, HasSpeaker, Twist
from wax.errors import ConfigError
from wax.robot.build_driver import limits_of
from wax.robot.find_driver import NO_WATCHDOG, NOT_BUILT, make_driver, make_robot
from wax.robot.process.driver import ProcessDriver
from wax.robot.simulated.chair import SimulatedChair
from wax.robot.simulated.robot import SimulatedRobot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from tests.robot.conftest import FakeClock


@pytest.mark.parametrize("name", ["simulated", "serial"])
def test_ours_are_found_by_name(name: str, clock: FakeClock) -> None:
    """The driver has the configured kind, and is not connected yet."""
    driver = make_driver(RobotSettings(driver=name), clock)
    assert driver.kind == name
    assert not driver.state().connected


def test_a_third_party_class_is_found(clock: FakeClock) -> None:
    """A driver named package.module:Class is built with settings and clock."""
    name = "wax.robot.simulated.robot:SimulatedRobot"
    assert (
        make_driver(RobotSettings(driver=name, max_linear_mps=0.2), clock).limits.linear_mps == 0.2
    )


def test_an_unknown_name_lists_the_known_ones(clock: FakeClock) -> None:
    """The error quotes the name and lists every possibility."""
    with pytest.raises(ConfigError, match=r"'tank'.*'serial', 'simulated'.*package\.module:Class"):
        make_driver(RobotSettings(driver="tank"), clock)


GOOD = """
from wax.driver.interface import Limits, RobotState

class Robot:
    kind = "wooden"
    limits = Limits(1.0, 1.0)
    def __init__(self, settings, clock): pass
    def open(self): pass
    def apply(self, twist, turn): pass
    def set_axis(self, name, position, turn): pass
    def stop(self, turn): pass
    def close(self): pass
    def state(self): return RobotState(connected=True)
"""
LIMITS = "limits = Limits(1.0, 1.0)"


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], str]]:
    """Write a module of this text where Python finds it; return the name of its robot."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def written(text: str) -> str:
        (tmp_path / "wooden_robot.py").write_text(text)
        return "wooden_robot:Robot"

    yield written
    sys.modules.pop("wooden_robot", None)


def test_a_complete_class_is_accepted(plugin: Callable[[str], str], clock: FakeClock) -> None:
    """A class in a file of the host's own is a driver."""
    assert make_driver(RobotSettings(driver=plugin(GOOD)), clock).kind == "wooden"


FORWARD_AND_TURN = """
from wax.driver.interface import STANDSTILL, Limits, RobotState, Twist

class Robot:
    kind = "wooden"
    limits = Limits(1.0, 1.5, ("pan",), 0.2, 0.12, ())
    def __init__(self, settings, clock): self.told = []
    def open(self): pass
    def apply(self, twist, turn):
        match twist:
            case Twist(linear, angular):
                assert twist == Twist(linear, angular)
                assert twist == Twist(angular_rps=angular, linear_mps=linear)
                assert twist.is_zero == (twist == STANDSTILL == Twist(0.0, 0.0) == Twist())
                assert len({twist, Twist(linear, angular)}) == 1
                self.told.append((linear, angular))
    def set_axis(self, name, position, turn): pass
    def stop(self, turn): pass
    def close(self): pass
    def state(self): return RobotState(connected=True)
"""


def test_a_driver_that_knows_of_forward_and_turn_runs_unchanged(
    plugin: Callable[[str], str], clock: FakeClock
) -> None:
    """Built, compared and taken apart by place or by name, a set-point is what it was."""
    driver = make_driver(RobotSettings(driver=plugin(FORWARD_AND_TURN)), clock)
    assert driver.limits.lateral_mps == 0.0
    for twist in (Twist(), Twist(0.4, -0.2), Twist(0.4, -0.2, 0.3)):
        driver.apply(within(twist, driver.limits), 1)
    assert vars(driver)["told"] == [(0.0, 0.0), (0.4, -0.2), (0.4, -0.2)]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("import no_such_module", "cannot import wooden_robot: No module named 'no_such_module'"),
        (
            "from wax.robot.driver import Twist",
            " imports wax.robot.driver, which is gone: its names are in wax.driver.interface now",
        ),
        ("class Robot", "importing wooden_robot failed: SyntaxError("),
        ("raise OSError('no bus')", "importing wooden_robot failed: OSError('no bus')"),
        ("Robot = 5", "wooden_robot has no class Robot"),
        (GOOD.replace("def stop", "def halt"), "wooden_robot:Robot has no method stop; see wax/"),
        (
            GOOD.replace("clock): pass", "clock): raise RuntimeError('no bus')"),
            "wooden_robot:Robot(settings, clock) failed: RuntimeError('no bus')",
        ),
        (GOOD.replace("clock)", "bus, clock)"), "(settings, clock) failed: TypeError("),
        (GOOD.replace(LIMITS, ""), "does not provide kind and limits: AttributeError("),
        (
            GOOD.replace(LIMITS, "@property\n    def limits(self): raise OSError('no bus')"),
            "does not provide kind and limits: OSError('no bus')",
        ),
        (GOOD.replace(LIMITS, "limits = (1.0, 1.0)"), "must have a text as kind and Limits as"),
        (GOOD.replace(LIMITS, "limits = Limits(1.0, -1.0)"), "must have limits from 0 on; got Lim"),
        (GOOD.replace(LIMITS, "limits = Limits(float('nan'), 1.0)"), "must have limits from 0 on"),
        (GOOD.replace(LIMITS, "limits = Limits(1.0, 1.0, lateral_mps=-1.0)"), "limits from 0 on"),
        (GOOD.replace(LIMITS, "limits = Limits(1.0, 1.0, ['pan'])"), "name its axes in a tuple"),
        (
            GOOD.replace(LIMITS, "limits = Limits(1.0, 1.0, (5,))"),
            "name its axes in a tuple; got (5",
        ),
        (
            GOOD.replace(LIMITS, "limits = Limits(1.0, 1.0, controls=['lamp'])"),
            "name its controls in a tuple; got ['lamp']",
        ),
        (
            GOOD.replace(LIMITS, "limits = Limits(1.0, 1.0, controls=('lamp',))"),
            "names controls, but has no method control.",
        ),
    ],
)
def test_a_plugin_that_cannot_be_used_is_one_sentence(
    plugin: Callable[[str], str], clock: FakeClock, text: str, sentence: str
) -> None:
    """Any fault of a plug-in is one line that names key and class, without a traceback."""
    with pytest.raises(ConfigError) as refused:
        make_driver(RobotSettings(driver=plugin(text)), clock)
    said = str(refused.value)
    assert said.startswith("robot.driver: wooden_robot:Robot")
    assert sentence in said
    assert "\n" not in said


def test_a_driver_that_cannot_move_sideways_says_so(
    plugin: Callable[[str], str], clock: FakeClock
) -> None:
    """Neither an older third-party driver nor MAVLink takes a configuration that asks for it."""
    wooden = plugin(GOOD)
    for name in (wooden, "mavlink"):
        assert make_driver(RobotSettings(driver=name), clock).limits.lateral_mps == 0.0
        with pytest.raises(ConfigError, match=rf"^robot\.max_lateral_mps: {name} cannot"):
            make_driver(RobotSettings(driver=name, base="omni"), clock)


@pytest.mark.parametrize(
    ("sideways", "configured", "speeds"),
    [
        ("lateral_mps=0.5", {}, (0.6, 0.9, 0.0)),
        ("lateral_mps=0.5", {"max_linear_mps": 2.0, "max_lateral_mps": 0.3}, (1.0, 0.9, 0.3)),
        ("lateral_mps=0.5", {"base": "omni", "max_angular_rps": 0.5}, (0.6, 0.5, 0.5)),
        ("ttl_s=0.2", {"max_linear_mps": 0.2}, (0.2, 0.9, 0.0)),
    ],
)
def test_no_driver_is_faster_than_configured(
    plugin: Callable[[str], str],
    clock: FakeClock,
    sideways: str,
    configured: dict[str, float],
    speeds: tuple[float, ...],
) -> None:
    """Each of its speeds is the lesser of its own and the configuration's; the rest is its own."""
    name = plugin(GOOD.replace(LIMITS, f"limits = Limits(1.0, 0.9, ('pan',), {sideways})"))
    settings = RobotSettings.model_validate({"driver": name, **configured})
    driver = make_driver(settings, clock)
    allowed = limits_of(driver, settings)
    assert (allowed.linear_mps, allowed.angular_rps, allowed.lateral_mps) == speeds
    assert (allowed.axes, allowed.ttl_s) == (driver.limits.axes, driver.limits.ttl_s)


@pytest.mark.parametrize("local", [None, LocalSettings(source="robot")])
def test_the_simulated_robot_needs_wheels_that_move_it_sideways(
    local: LocalSettings | None, clock: FakeClock
) -> None:
    """On two driven sides it takes no speed sideways, with nobody or somebody aboard."""
    settings = RobotSettings(max_lateral_mps=0.3)
    with pytest.raises(ConfigError, match=r"^robot\.max_lateral_mps: simulated cannot"):
        make_robot(settings, clock, local=local)
    can = make_robot(settings.model_copy(update={"base": "mecanum"}), clock, local=local)
    assert can.limits.lateral_mps == 0.3


def test_a_missing_plugin_is_an_error(clock: FakeClock) -> None:
    """The error for a module that is not installed names the key and the module."""
    with pytest.raises(ConfigError, match=r"^robot\.driver: no\.such:Robot: cannot import no\.suc"):
        make_driver(RobotSettings(driver="no.such:Robot"), clock)


_EXTRA_OF = {"cyclonedds": "ros2", "gpiozero": "gpio", "pymavlink": "mavlink"}


class _Absent:
    """Python's first finder, which hides a library."""

    def __init__(self, library: str) -> None:
        self._library = library

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        if name.split(".", maxsplit=1)[0] == self._library:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Hide a library, and unload it and those of our modules that have loaded it."""

    def taken(library: str) -> None:
        names = ("codec", "conversation", "dds_link")
        ours = [f"wax.robot.{_EXTRA_OF[library]}.{name}" for name in names]
        for name in [name for name in sys.modules if name.split(".")[0] == library or name in ours]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setattr(sys, "meta_path", [_Absent(library), *sys.meta_path])

    return taken


@pytest.mark.parametrize("library", _EXTRA_OF)
def test_a_missing_extra_names_the_command_that_installs_it(
    library: str, clock: FakeClock, without: Callable[[str], None]
) -> None:
    """The server does not start without its library, and one line says what to type."""
    extra = _EXTRA_OF[library]
    without(library)
    with pytest.raises(ConfigError) as refused:
        make_robot(RobotSettings(driver=extra), clock)
    assert str(refused.value) == (
        f"robot.driver: {extra} needs {library}, which is not installed:"
        f' pip install "wax-teleop[{extra}]"'
    )


def test_a_rosbridge_needs_no_extra(clock: FakeClock, without: Callable[[str], None]) -> None:
    """Without DDS, a robot on ROS 2 is still reached by rosbridge."""
    without("cyclonedds")
    tree = {"driver": "ros2", "ros2": {"transport": "rosbridge"}}
    assert make_robot(RobotSettings.model_validate(tree), clock).kind == "ros2"


EYE = "\n    def camera(self, settings, clock): pass"
EAR = "\n    def microphone(self, clock): pass"


@pytest.mark.system
@pytest.mark.parametrize("text", [GOOD + EYE, *at_length(GOOD, GOOD + EAR)])
def test_every_third_party_robot_gets_a_process(
    plugin: Callable[[str], str], clock: FakeClock, text: str
) -> None:
    """The server uses a `ProcessDriver` with the robot's own kind, limits and senses."""
    robot = make_robot(RobotSettings(driver=plugin(text)), clock)
    assert isinstance(robot, ProcessDriver)
    assert (robot.kind, robot.limits.linear_mps) == ("wooden", RobotSettings().max_linear_mps)
    assert isinstance(robot, HasCamera) == (EYE in text)
    assert isinstance(robot, HasMicrophone) == (EAR in text)
    assert "wooden_robot" not in sys.modules


def test_the_simulated_robot_runs_in_the_server(clock: FakeClock) -> None:
    """Its cameras need its pose, which only its own process knows."""
    assert isinstance(make_robot(RobotSettings(), clock), SimulatedRobot)
    assert isinstance(make_robot(RobotSettings(driver="serial"), clock), ProcessDriver)


ABOARD = LocalSettings(source="robot")
HAND = "\n    def hand(self): pass"
WATCHDOG = GOOD.replace(LIMITS, "limits = Limits(1.0, 1.0, ttl_s=0.2)")


@pytest.mark.system
@pytest.mark.parametrize("senses", [EYE, *at_length("")])
def test_a_robot_with_a_hand_control_allows_a_person_aboard(
    plugin: Callable[[str], str], clock: FakeClock, senses: str
) -> None:
    """So does a control on a serial line of its own; senses do not matter."""
    text = WATCHDOG + HAND + senses
    robot = make_robot(RobotSettings(driver=plugin(text)), clock, local=ABOARD)
    assert isinstance(robot, ProcessDriver)
    line = LocalSettings(source="serial")
    assert isinstance(make_robot(RobotSettings(driver="serial"), clock, local=line), ProcessDriver)


@pytest.mark.system
@pytest.mark.parametrize(
    ("text", "why"),
    [
        (WATCHDOG, r"^local\.source: .* has no hand control"),
        (GOOD + HAND, r"^local\.source: .* no watchdog of its own"),
        *at_length((WATCHDOG.replace("0.2", "5.0") + HAND, r"^local\.source: .* only after 5 s")),
        ("raise OSError('no bus')", r"^robot\.driver: .*no bus"),
    ],
)
def test_nobody_is_aboard_a_robot_that_they_could_not_stop(
    plugin: Callable[[str], str], clock: FakeClock, text: str, why: str
) -> None:
    """WAX does not start without a hand control, or without a watchdog of the robot itself."""
    with pytest.raises(ConfigError, match=why):
        make_robot(RobotSettings(driver=plugin(text)), clock, local=ABOARD)


def test_somebody_may_sit_in_the_simulated_robot(clock: FakeClock) -> None:
    """The simulated chair keeps its senses, and reports that it stops by itself in silence."""
    robot = make_robot(RobotSettings(silence_ms=120), clock, local=ABOARD)
    assert isinstance(robot, SimulatedChair)
    assert isinstance(robot, HasCamera)
    assert isinstance(robot, HasMicrophone)
    assert isinstance(robot, HasSpeaker)
    assert robot.limits.silence_s == 0.12


@pytest.mark.system
@pytest.mark.parametrize(("text", "warned"), [(GOOD, True), (WATCHDOG + EYE, False)])
def test_a_robot_without_a_watchdog_logs_a_warning(
    plugin: Callable[[str], str], clock: FakeClock, text: str, warned: bool
) -> None:
    """The warning says that it keeps moving if its driver's process hangs."""
    with capture_logs() as logs:
        make_robot(RobotSettings(driver=plugin(text)), clock)
    assert [line["event"] for line in logs] == [NO_WATCHDOG] * warned


@pytest.mark.system
@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("raise OSError('no bus')", "importing wooden_robot failed: OSError('no bus')"),
        *at_length(("raise SystemExit('no bus')", "ends the process that builds it (status 0)")),
        ("import os\nos.abort()", "ends the process that builds it (signal 6)"),
        (GOOD.replace(LIMITS, "limits = Limits(1.0, 1.0, ttl_s='soon')"), "must have limits from"),
    ],
)
def test_a_driver_that_fails_while_it_is_built_ends_no_server(
    plugin: Callable[[str], str], clock: FakeClock, text: str, why: str
) -> None:
    """The log says why; the server keeps running, with the configured limits."""
    settings = RobotSettings(driver=plugin(text), max_linear_mps=0.4, base="omni")
    with capture_logs() as logs:
        robot = make_robot(settings, clock)
    (told, _) = logs
    assert told["event"] == NOT_BUILT
    assert why in told["problem"]
    assert (robot.limits.linear_mps, robot.limits.lateral_mps) == (0.4, 0.4)
    assert robot.limits.ttl_s is None
    assert not robot.state().connected
    assert isinstance(robot, HasCamera)


@pytest.mark.system
def test_a_missing_driver_ends_the_start(clock: FakeClock) -> None:
    """A wrong name in the configuration is an error, and the server does not start."""
    with pytest.raises(ConfigError, match=r"^robot\.driver: no\.such:Robot: cannot import no\.suc"):
        make_robot(RobotSettings(driver="no.such:Robot"), clock)


LAMP = ControlSettings(name="lamp", kind="toggle")


def test_a_control_must_be_one_of_the_robots() -> None:
    """A misspelt control lists those there are; without any, the error says what to do."""
    settings = RobotSettings()
    assert make_robot(settings, SystemClock(), controls=[LAMP]).limits.controls[0] == "lamp"
    wrong = LAMP.model_copy(update={"name": "lmap"})
    with pytest.raises(ConfigError) as refused:
        make_robot(settings, SystemClock(), controls=[LAMP, wrong])
    assert str(refused.value) == (
        "controls[1].name: got 'lmap'; the driver simulated has lamp, horn, brightness, light,"
        " look_around"
    )
    with pytest.raises(ConfigError) as refused:
        make_robot(settings.model_copy(update={"driver": "serial"}), SystemClock(), controls=[LAMP])
    assert str(refused.value) == (
        "controls: the driver serial has no controls; leave the tables [[controls]] out,"
        " or use a driver that names some in its limits"
    )
