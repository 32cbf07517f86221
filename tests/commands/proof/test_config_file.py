"""The configuration of the server under proof."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

import pytest
from tests.commands.proof.robots import WheelSettings

from wax.commands.proof.config_file import check, check_stop, observed, tapped
from wax.commands.proof.observed import ObservedSettings
from wax.config.robot import RobotSettings
from wax.config.settings import Settings, parse
from wax.errors import ConfigError
from wax.session.kept_state import FILE, KeptState

if TYPE_CHECKING:
    from pathlib import Path

HOSTS: dict[str, Any] = {
    "server": {"host": "0.0.0.0", "port": 80},
    "network": {"stun": ["stun:example.org"]},
    "relay": {"urls": ["turn:example.org"], "secret": "x"},
    "video": {"source": "camera:0"},
    "audio": {"source": "microphone"},
    "sync": {"policy": "thesis"},
    "turns": {"turn_s": 1.0, "grace_s": 0.5},
    "drive": {"max_age_ms": 120.0, "slow_fraction": 0.2},
    "stop": {"by": "operator"},
    "robot": {
        "driver": "serial",
        "max_linear_mps": 0.4,
        "silence_ms": 100,
        "soft_braking": True,
        "serial": {
            "url": "/dev/real",
            "baud": 57600,
            "ttl_ms": 180,
            "axes": ["pan"],
            "bytes": {"fine": "none"},
        },
    },
}


def proved() -> Settings:
    text = tapped(parse(HOSTS, "the host"), '/dev/pts/7 "x"\x7f', "/tmp/state")
    return parse(tomllib.loads(text), "the proof")


def test_what_stops_the_robot_is_the_hosts_own() -> None:
    """The proof uses [drive], [stop] and [robot] as configured, except for the port."""
    hosts, used = parse(HOSTS, "the host"), proved()
    assert used.drive == hosts.drive
    assert used.stop == hosts.stop
    assert used.robot.serial.url == '/dev/pts/7 "x"\x7f'
    serial = used.robot.serial.model_copy(update={"url": "/dev/real"})
    assert used.robot.model_copy(update={"serial": serial}) == hosts.robot


def test_nothing_else_of_the_hosts_is_used() -> None:
    """The proof uses no camera, microphone or outside host, and no turn ends during it."""
    used = proved()
    assert used.video.source == used.audio.source == "none"
    assert used.network.stun == used.relay.urls == []
    assert used.network.udp_port == 0
    assert used.sync.policy == "by-role"
    assert used.turns.turn_s == 86_400.0
    assert used.turns.grace_s == 0.5


def test_a_robot_of_the_hosts_own_is_proved_as_it_is_configured() -> None:
    """A foreign driver gets its whole [robot], its own table included."""
    own_table = {"driver": "tests.commands.proof.robots:Moving", "wheels": {"bus": 5}}
    hosts = parse(HOSTS | {"robot": HOSTS["robot"] | own_table}, "the host")
    used = parse(tomllib.loads(observed(hosts, "/tmp/log", "/tmp/state")), "the proof")
    own = used.robot.own(ObservedSettings)
    handed_on = RobotSettings.model_validate_json(own.robot)
    assert handed_on == hosts.robot
    assert handed_on.own(WheelSettings).bus == 5
    assert own.log == "/tmp/log"
    assert used.robot.driver == "wax.commands.proof.observed:ObservedRobot"
    assert (used.robot.max_linear_mps, used.robot.silence_ms) == (0.4, 100)
    assert used.drive == hosts.drive


def test_the_simulated_robot_is_refused_in_a_sentence() -> None:
    """The simulated robot is refused, since it proves nothing."""
    with pytest.raises(ConfigError, match="nothing to prove"):
        check(parse({"robot": {"driver": "simulated"}}, "the host"))


def test_a_robot_with_somebody_aboard_is_not_driven_for_a_proof() -> None:
    """A robot with a person aboard is refused, with how to prove it all the same."""
    with pytest.raises(ConfigError, match="prove the stop of the empty robot"):
        check(parse(HOSTS | {"local": {"source": "serial"}}, "the host"))


def test_a_robot_whose_stop_is_in_force_is_not_driven_for_a_proof(tmp_path: Path) -> None:
    """A Stop in force refuses the proof, although no server runs."""
    (tmp_path / FILE).write_text(KeptState(stop="host").model_dump_json())
    with pytest.raises(ConfigError, match="release the Stop"):
        check_stop(parse(HOSTS | {"server": {"state_dir": str(tmp_path)}}, "the host"))


@pytest.mark.parametrize("driver", ["serial", "mine.robots:Robot"])
def test_a_real_robot_can_be_proved(driver: str) -> None:
    """Any real robot's driver is accepted."""
    check(parse({"robot": {"driver": driver}}, "the host"))
