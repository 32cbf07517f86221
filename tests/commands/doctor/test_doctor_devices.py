"""Devices: those that deliver, those that do not, and those left alone."""

from __future__ import annotations

import os
import pty
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest
import serial
from tests.commands.doctor.sources import Dark

from wax.commands.doctor import devices
from wax.commands.doctor.verdict import ok
from wax.config.settings import Settings
from wax.robot.serial.list_ports import ListedPort

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from wax.commands.doctor.verdict import Verdict


def _settings(video: str = "none", audio: str = "none", **robot: Any) -> Settings:
    return Settings.model_validate(
        {"video": {"source": video}, "audio": {"source": audio}, "robot": robot}
    )


def _camera(source: str, *, running: bool = False) -> Verdict:
    return devices.camera(_settings(video=source), running=running)


def _microphone(source: str, *, running: bool = False) -> Verdict:
    return devices.microphone(_settings(audio=source), running=running)


def test_a_camera_that_gives_pictures_is_well() -> None:
    """A camera that delivers is ok, with its picture's size."""
    verdict = _camera("testcard")
    assert (verdict.level, "640×480" in verdict.sentence) == ("ok", True)


def test_a_camera_by_which_nobody_drives_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A camera without known picture ages is a warning that says why nobody drives by it."""
    monkeypatch.setattr(devices, "_DATED_S", 0.05)
    plugin = _camera("tests.commands.doctor.sources:Undated")
    assert (plugin.level, "within_s" in plugin.advice) == ("warning", True)
    still = tmp_path / "snapshot.png"
    cv2.imwrite(str(still), np.zeros((48, 64, 3), np.uint8))
    picture = _camera(str(still))
    assert (picture.level, "nobody knows how old" in picture.advice) == ("warning", True)


@pytest.mark.parametrize(
    ("source", "says"),
    [
        ("/dev/video-that-is-not-there", "There is no camera"),
        ("nowhere.mp4", "does not exist"),
        ("tests.commands.doctor.sources:Dark", "no picture"),
        ("tests.commands.doctor.sources:Missing", "Missing"),
    ],
)
def test_a_camera_that_gives_none_is_bad(source: str, says: str) -> None:
    """A missing device, file or class, and a camera that delivers nothing, are bad."""
    verdict = _camera(source)
    assert (verdict.level, says in verdict.sentence) == ("bad", True), verdict
    assert "video.source" in verdict.advice


def test_a_camera_is_closed_after_its_failure() -> None:
    """A camera is closed after a failure."""
    before = Dark.closed
    _camera("tests.commands.doctor.sources:Dark")
    assert Dark.closed == before + 1


def test_a_microphone_is_heard() -> None:
    """Sound is ok, a constant is a warning, and a missing microphone is bad."""
    assert _microphone("testcard") == ok("The microphone testcard gives sound, in mono.")
    for source in ("robot", "auto"):
        heard = _microphone(source)
        assert heard == ok("The microphone of the robot gives sound, in stereo."), source
    deaf = _microphone("tests.commands.doctor.sources:DeafOnTheLeft")
    assert (deaf.level, "The left channel" in deaf.sentence) == ("warning", True)
    muted = _microphone("tests.commands.doctor.sources:Muted")
    assert (muted.level, "muted" in muted.advice) == ("warning", True)
    assert _microphone("microphone:no such device").level == "bad"


def test_what_is_not_wanted_is_well() -> None:
    """A device that is not configured is ok."""
    verdicts = [_camera("none"), _microphone("none")]
    verdicts.append(devices.serial_port(_settings(), running=False))
    assert {verdict.level for verdict in verdicts} == {"ok"}


def test_a_running_server_keeps_its_devices() -> None:
    """Devices of a running server are not opened."""
    settings = _settings(driver="serial", serial={"url": "/dev/none"})
    verdicts = [_camera("camera:99", running=True), _microphone("microphone:99", running=True)]
    verdicts.append(devices.serial_port(settings, running=True))
    assert {verdict.level for verdict in verdicts} == {"warning"}


@contextmanager
def _terminal() -> Iterator[tuple[int, str]]:
    """Open a pseudo-terminal; yields its controlling end and the name of the other."""
    control, line = pty.openpty()
    yield control, os.ttyname(line)
    os.close(control)
    os.close(line)


def _serial(url: str) -> Verdict:
    return devices.serial_port(_settings(driver="serial", serial={"url": url}), running=False)


def test_a_serial_port_opens_without_a_word() -> None:
    """A serial port is opened and closed without sending a byte."""
    with _terminal() as (control, name):
        assert _serial(name).level == "ok"
        os.set_blocking(control, False)
        with pytest.raises(BlockingIOError):
            os.read(control, 1)


def test_a_board_without_a_known_watchdog_is_told() -> None:
    """A board without a known watchdog is a warning, although its port opens."""
    with _terminal() as (_, name):
        lines = {"drive": "m {left} {right}\r", "per_mps": 1000.0}
        serial = {"url": name, "dialect": "text", "text": lines}
        settings = _settings(driver="serial", serial=serial)
        verdict = devices.serial_port(settings, running=False)
    assert verdict.level == "warning"
    assert "a pulled cable leaves the robot moving" in verdict.sentence
    assert "timeout" in verdict.advice


def test_a_port_that_may_be_another_board_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """With two boards plugged in, a port by its number is a warning with the name to write."""
    with _terminal() as (_, name):
        boards = [
            ListedPort("/dev/serial/by-path/hub-1", name, "", is_usb=True),
            ListedPort("/dev/serial/by-path/hub-2", "/dev/ttyUSB9", "", is_usb=True),
        ]
        monkeypatch.setattr(devices, "find_ports", lambda: boards)
        verdict = _serial(name)
    assert (verdict.level, "may be another board" in verdict.sentence) == ("warning", True)
    assert verdict.advice == 'Write [robot.serial] url = "/dev/serial/by-path/hub-1".'


def test_a_serial_port_that_is_used_is_told() -> None:
    """A serial port in use by another program is bad."""
    with _terminal() as (_, name), serial.Serial(name, exclusive=True):
        verdict = _serial(name)
    assert (verdict.level, "Another program" in verdict.sentence) == ("bad", True), verdict


def test_a_serial_port_that_is_missing_is_told(tmp_path: Path) -> None:
    """A missing serial port or an unknown kind of URL is bad."""
    missing = _serial(str(tmp_path / "ttyACM9"))
    assert (missing.level, "There is no serial port" in missing.sentence) == ("bad", True)
    assert "Plug its cable in" in missing.advice
    assert _serial("nonsense://here").level == "bad"


@pytest.mark.parametrize(
    ("source", "level", "says"),
    [
        ("testcard", "ok", "The camera Door gives pictures of 640×480"),
        ("robot", "ok", "The camera Door gives pictures"),
        ("tests.commands.doctor.sources:Dark", "bad", "Door: "),
        ("nowhere.mp4", "bad", "camera Door: "),
    ],
)
def test_a_camera_beside_the_driving_view_is_named(source: str, level: str, says: str) -> None:
    """Each further camera is opened and read, and its verdict names it."""
    settings = Settings.model_validate({"camera": [{"name": "Door", "source": source}]})
    verdict = devices.further_camera(settings, settings.camera[0], running=False)
    assert (verdict.level, says in verdict.sentence) == (level, True), verdict
    assert devices.further_camera(settings, settings.camera[0], running=True).level == "warning"
