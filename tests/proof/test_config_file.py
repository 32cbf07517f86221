"""The configuration of the server under proof."""

from __future__ import annotations

import tomllib

import pytest

from wax.config.settings import Settings, parse
from wax.errors import ConfigError
from wax.proof.config_file import check, under_proof, write

HOSTS = {
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
    text = under_proof(parse(HOSTS, "the host"), '/dev/pts/7 "x"\x7f', "/tmp/state")
    return parse(tomllib.loads(text), "the proof")


def test_what_stops_the_robot_is_the_hosts_own() -> None:
    """Everything in [drive], [stop] and [robot] is proved as it is configured, but for the port."""
    hosts, used = parse(HOSTS, "the host"), proved()
    assert used.drive == hosts.drive
    assert used.stop == hosts.stop
    assert used.robot.serial.url == '/dev/pts/7 "x"\x7f'
    serial = used.robot.serial.model_copy(update={"url": "/dev/real"})
    assert used.robot.model_copy(update={"serial": serial}) == hosts.robot


def test_nothing_else_of_the_hosts_is_used() -> None:
    """No camera, no microphone, no outside host, and no turn that ends meanwhile."""
    used = proved()
    assert used.video.source == used.audio.source == "none"
    assert used.network.stun == used.relay.urls == []
    assert used.network.udp_port == 0
    assert used.sync.policy == "by-role"
    assert used.turns.turn_s == 86_400.0
    assert used.turns.grace_s == 0.5


@pytest.mark.parametrize(
    ("driver", "says"),
    [("simulated", "nothing to prove"), ("mine.robots:Robot", "serial line")],
)
def test_robots_without_a_line_are_refused_in_a_sentence(driver: str, says: str) -> None:
    """Only a robot on a serial line can be proved; the others are told why not."""
    with pytest.raises(ConfigError, match=says):
        check(parse({"robot": {"driver": driver}}, "the host"))


def test_a_robot_with_somebody_aboard_is_not_driven_for_a_proof() -> None:
    """It would drive them without their control; the host reads how to prove it all the same."""
    with pytest.raises(ConfigError, match="prove the stop of the empty robot"):
        check(parse(HOSTS | {"local": {"source": "serial"}}, "the host"))


def test_a_robot_on_a_serial_line_can_be_proved() -> None:
    """It is what the proof is made for."""
    check(parse(HOSTS, "the host"))


def test_what_toml_cannot_say_is_not_written() -> None:
    """A value that is none of TOML's is an error here, not a file that cannot be read."""
    with pytest.raises(TypeError):
        write({"key": None})
