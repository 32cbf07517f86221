"""Renders a first configuration: the choices, their reasons, and the alternatives. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.commands.init.questions import THIS_MACHINE
from wax.config import manual
from wax.config.as_toml import as_toml
from wax.config.drive import DriveSettings
from wax.config.robot import RobotSettings
from wax.config.serial import SerialSettings
from wax.logs.printable import printable

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic import BaseModel

    from wax.commands.init.found import Found, Thing
    from wax.commands.init.questions import Answers

_NAME_CHARS: Final = 80


def render(answers: Answers, found: Found, name: str, day: str) -> str:
    """Return the TOML; `name` is the file's name and `day` today's date."""
    parts = [
        f"# Written by `wax init` on {day}. Start it with: wax --config {name}\n"
        f"# Check it with: wax doctor --config {name}\n"
        "# config/wax.toml is the manual of every other key, with its range and its reason.\n",
        _server(answers),
        _video(answers, found),
        _audio(answers, found),
        _voice(answers, found),
        _robot(answers, found),
    ]
    return "\n".join(parts)


def _server(answers: Answers) -> str:
    if answers.host == THIS_MACHINE:
        return (
            "[server]\n"
            '# Only this machine opens the page; "0.0.0.0" lets every device in your network in.\n'
            f"host = {as_toml(answers.host)}\n"
        )
    return (
        "[server]\n"
        '# Every device in your network opens the page; "localhost" lets only this machine in.\n'
        f"host = {as_toml(answers.host)}\n"
        "# Browsers give their microphone to pages by HTTPS only. The certificate is made here:\n"
        "# each browser asks once; compare its fingerprint with the one on the terminal.\n"
        "https = true\n"
    )


def _video(answers: Answers, found: Found) -> str:
    auto = (
        '# No camera was there when this was written. "auto" takes the first one that is found;\n'
        "# until then the page says that there is none, and nobody can drive.\n"
        if answers.camera == "auto" and not found.cameras
        else ""
    )
    return (
        "[video]\n"
        "# The camera that looks where the robot drives: nobody drives without its picture.\n"
        f"{auto}"
        f"source = {as_toml(answers.camera)}{_about(answers.camera, found.cameras)}\n"
        f"{_others('source', answers.camera, found.cameras)}"
    )


def _audio(answers: Answers, found: Found) -> str:
    return (
        "[audio]\n"
        "# \"auto\" is the robot's own microphone, else the system's default, else the first.\n"
        f"source = {as_toml(answers.microphone)}{_about(answers.microphone, found.microphones)}\n"
        f"{_others('source', answers.microphone, found.microphones)}"
    )


def _voice(answers: Answers, found: Found) -> str:
    return (
        "[voice]\n"
        '# Where the operator\'s voice is played beside the robot; "none": nobody can speak.\n'
        f"speaker = {as_toml(answers.speaker)}{_about(answers.speaker, found.speakers)}\n"
        f"{_others('speaker', answers.speaker, found.speakers)}"
    )


def _robot(answers: Answers, found: Found) -> str:
    defaults, drive = RobotSettings(), DriveSettings()
    text = (
        "[robot]\n"
        f"driver = {as_toml(answers.driver)}\n"
        "# The highest speeds. Begin low, and raise them once `wax prove-stop` has measured how\n"
        "# fast it stops: after losing its operator it may travel"
        f" {drive.max_stop_distance_m:g} m.\n"
        f"max_linear_mps = {defaults.max_linear_mps!r}   # metres a second\n"
        f"max_angular_rps = {defaults.max_angular_rps!r}   # radians a second\n"
        f"{_key(defaults, 'braking_mps2')}"
    )
    if answers.driver == "simulated":
        return text
    text += _key(defaults, "wheel_base_m")
    if answers.driver != "serial":
        return text + _own_table(answers.driver)
    serial = SerialSettings()
    return (
        f"{text}"
        "\n"
        "[robot.serial]\n"
        f"url = {as_toml(answers.port)}{_about(answers.port, found.ports)}\n"
        f"{_others('url', answers.port, found.ports)}"
        f"{_key(serial, 'dialect')}"
        f"{_key(serial, 'baud')}"
    )


def _key(table: BaseModel, key: str) -> str:
    """Return a key with its default, and what the manual says of it."""
    said = manual.comment(manual.purposes(type(table))[key])
    return "\n".join([*said, f"{key} = {as_toml(getattr(table, key))}", ""])


def _own_table(driver: str) -> str:
    """Return a comment that says how to list the driver's own keys."""
    return (
        "\n# Where the robot is, and all else that only this driver asks for, has its own table:\n"
        f"# `wax config {driver}` shows the keys, each with its range, its reason and the value\n"
        "# that it has while it is not written here. `wax devices` lists the serial ports.\n"
    )


def _about(chosen: str, things: Iterable[Thing]) -> str:
    """Return a comment with the name of what was chosen."""
    name = next((one.name for one in things if one.source == chosen), "")
    return f"   # {printable(name, _NAME_CHARS)}" if name else ""


def _others(key: str, chosen: str, things: Iterable[Thing]) -> str:
    """Return comments with the other devices found."""
    others = [one for one in things if one.source != chosen]
    if not others:
        return ""
    lines = [f"# {key} = {as_toml(one.source)}{_about(one.source, [one])}\n" for one in others]
    return "# Also found:\n" + "".join(lines)
