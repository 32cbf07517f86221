"""The questions of `wax init` and the file: few questions, sensible defaults, valid TOML."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.commands.init import questions
from wax.commands.init.found import Found, Thing
from wax.commands.init.questions import Answers, Key
from wax.commands.init.writing import render
from wax.config import settings as config

MANUAL = (Path(__file__).parents[3] / "config/wax.toml").read_text(encoding="utf-8")
BENCH = Found(
    cameras=(Thing("/dev/v4l/by-id/usb-Acme", "HD Webcam"), Thing("/dev/video2", "Infrared")),
    microphones=(Thing("microphone:HD Webcam", "HD Webcam: USB Audio (hw:1,0)"),),
    speakers=(Thing("speaker:Jabra", "Jabra: USB Audio (hw:2,0)"),),
    ports=(Thing("/dev/serial/by-id/usb-Arduino", "Arduino Uno"), Thing("/dev/ttyS0", "")),
    plugged=1,
    drivers=("ros2",),
)


def defaults(found: Found, port: str | None = None) -> dict[Key, str]:
    """Answer every question with Enter."""
    first = questions.robot(found, port)
    given: dict[Key, str] = {"robot": first.choices[0].value}
    for question in questions.others(found, given["robot"].partition(" ")[0]):
        given[question.key] = question.choices[0].value
    return given


def test_what_is_plugged_in_is_the_default() -> None:
    """By default, a USB board is the robot, and the page is for this machine only."""
    assert questions.answers(defaults(BENCH)) == Answers(
        driver="serial",
        port="/dev/serial/by-id/usb-Arduino",
        camera="/dev/v4l/by-id/usb-Acme",
        microphone="auto",
        speaker="none",
        host="localhost",
    )


def test_with_nothing_there_it_is_the_simulated_robot() -> None:
    """An empty port is not the default robot, but can be chosen."""
    bare = Found(ports=(Thing("/dev/ttyS0", ""),))
    assert questions.answers(defaults(bare)) == Answers(
        "simulated", "", "robot", "robot", "none", "localhost"
    )
    assert "serial /dev/ttyS0" in [one.value for one in questions.robot(bare, None).choices]


def test_a_port_that_was_named_is_the_robot() -> None:
    """A port given by `--serial` is the default."""
    given = defaults(BENCH, "socket://10.0.0.7:4000")
    assert questions.answers(given).port == "socket://10.0.0.7:4000"


@pytest.mark.parametrize("driver", ["serial", "simulated", "ros2"])
@pytest.mark.parametrize("found", [BENCH, Found()])
def test_at_most_five_questions(found: Found, driver: str) -> None:
    """There are at most five questions, each with a default and without duplicate answers."""
    asked = [questions.robot(found, None), *questions.others(found, driver)]
    assert len(asked) <= 5
    for question in asked:
        values = [one.value for one in question.choices]
        assert values
        assert len(set(values)) == len(values)


def test_a_default_is_explained_as_in_the_manual() -> None:
    """The file says of the keys that it leaves as they are what the manual says."""
    text = render(questions.answers(defaults(BENCH)), BENCH, "robot.toml", "today")
    for key in ("braking_mps2", "wheel_base_m", "dialect", "baud"):
        said = re.findall(rf"^((?:# .*\n)+)# Allowed: .*\n{key} = ", MANUAL, re.MULTILINE)
        assert any(f"{one}{key} = " in text for one in said), key


def test_a_plug_in_may_have_a_camera_of_its_own() -> None:
    """The default for a plug-in robot is its own camera."""
    camera = next(questions.others(BENCH, "ros2"))
    assert camera.choices[0].value == "auto"
    assert camera.choices[1].value == "/dev/v4l/by-id/usb-Acme"


@pytest.mark.parametrize("found", [BENCH, Found()])
def test_what_is_written_is_what_was_chosen(found: Found) -> None:
    """The file loads as the server loads it, and lists the other devices found."""
    chosen = questions.answers(defaults(found))
    text = render(chosen, found, "robot.toml", "2026-11-24")
    settings = config.parse(tomllib.loads(text), "robot.toml")
    assert settings.video.source == chosen.camera
    assert settings.audio.source == chosen.microphone
    assert settings.voice.speaker == chosen.speaker
    assert settings.robot.driver == chosen.driver
    assert settings.server.host == "localhost"
    assert not settings.server.https
    if chosen.port:
        assert settings.robot.serial.url == chosen.port
        assert '# source = "/dev/video2"   # Infrared' in text
        assert '# url = "/dev/ttyS0"' in text


@pytest.mark.parametrize("driver", ["gpio", "mavlink", "ros2"])
def test_a_driver_with_a_table_of_its_own_says_where_that_is(driver: str) -> None:
    """The file loads unchanged, and names the command that lists the driver's keys."""
    chosen = Answers(driver, "", "auto", "auto", "none", "localhost")
    text = render(chosen, BENCH, "robot.toml", "today")
    settings = config.parse(tomllib.loads(text), "robot.toml")
    assert settings.robot.driver == driver
    assert f"`wax config {driver}`" in text
    assert f"\nwheel_base_m = {settings.robot.wheel_base_m}\n" in text
    assert max(map(len, text.splitlines())) <= 100
    assert f"[robot.{driver}]" in config.describe_drivers([driver])


def test_a_network_gets_https() -> None:
    """A page for the network is served by HTTPS, which microphones require."""
    chosen = Answers("simulated", "", "robot", "robot", "robot", "0.0.0.0")
    settings = config.parse(tomllib.loads(render(chosen, BENCH, "r.toml", "today")), "r.toml")
    assert (settings.server.host, settings.server.https) == ("0.0.0.0", True)


NAME = st.text(max_size=120)


@examples(200)
@given(source=NAME.filter(bool), name=NAME, other=NAME.filter(bool))
def test_no_device_can_write_the_configuration(source: str, name: str, other: str) -> None:
    """A device's name can change nothing in the file but its own value."""
    cameras = (Thing(source, name), Thing(other, name))
    found = Found(cameras=cameras, ports=(Thing("/dev/ttyACM0", name),), plugged=1)
    chosen = Answers("serial", "/dev/ttyACM0", source, "auto", "none", "localhost")
    tree = tomllib.loads(render(chosen, found, "robot.toml", "today"))
    assert tree["video"] == {"source": source}
    assert tree["robot"]["serial"] == {"url": "/dev/ttyACM0", "dialect": "frames", "baud": 115_200}
    assert set(tree) == {"server", "video", "audio", "voice", "robot"}
