"""The programs of `config/examples` do what they say, with the configuration that they say."""

from __future__ import annotations

import asyncio
import importlib
import runpy
import socket
import sys
import textwrap
import tomllib
from asyncio.subprocess import DEVNULL, PIPE
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import cv2
import numpy as np
import pytest
from gpiozero import Device
from gpiozero.pins.mock import MockFactory, MockPWMPin
from tests.dataset.driven_tape import commanded, steered
from tests.free_port import free_port
from tests.hooks.receiver import secret_file
from tests.turned_clock import TurnedClock
from tests.until import until

from wax.capture.find_sources import make_sources
from wax.clock import SystemClock
from wax.commands.hook.command import hook_test
from wax.config import settings as config
from wax.driver.interface import HasControls
from wax.robot.build_driver import make_driver
from wax.robot.check_controls import check_controls
from wax.tape.event_file import EventFile

if TYPE_CHECKING:
    from types import ModuleType

EXAMPLES: Final = Path(__file__).parents[2] / "config/examples"
MOST_LINES: Final = 40
FILES: Final = sorted(path.name for path in EXAMPLES.iterdir() if path.is_file())


def configured(name: str, text: str = "") -> config.Settings:
    """Return the configuration in an example's first words, or in `text`."""
    paragraphs = (text or (EXAMPLES / name).read_text(encoding="utf-8")).split("\n\n")
    said = [textwrap.dedent(one) for one in paragraphs if one.startswith("    [")]
    return config.parse(tomllib.loads("\n".join(said)), name)


@pytest.fixture
def imported(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Import an example as the server does with this folder in PYTHONPATH."""
    monkeypatch.syspath_prepend(str(EXAMPLES))
    loaded: list[str] = []

    def load(name: str) -> ModuleType:
        loaded.append(name)
        return importlib.import_module(name)

    yield load
    for name in loaded:
        del sys.modules[name]


@pytest.mark.parametrize("name", FILES)
def test_an_example_is_short(name: str) -> None:
    """Each is read at a glance."""
    assert len((EXAMPLES / name).read_text(encoding="utf-8").splitlines()) <= MOST_LINES


def film(path: Path, grey: int) -> str:
    """Write a film of one shade."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, (64, 48))
    for _ in range(3):
        writer.write(np.full((48, 64, 3), grey, np.uint8))
    writer.release()
    return str(path)


def test_two_cameras_are_one_picture(
    imported: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The left one is on the left, people may drive by both, and one that ends is an error."""
    eyes = imported("two_cameras")
    films = film(tmp_path / "left.avi", 60), film(tmp_path / "right.avi", 200)
    monkeypatch.setattr(eyes, "DEVICES", films)
    settings = configured("two_cameras.py")
    clock = TurnedClock()
    driver = make_driver(settings.robot, clock)
    camera = make_sources(settings.video, settings.audio, clock, driver).video
    assert camera is not None
    camera.open()
    picture = camera.read()
    assert (picture.width, picture.height) == (128, 48)
    left, right = picture.i420[:48, :64], picture.i420[:48, 64:]
    assert left.mean() < 100 < right.mean()
    assert picture.captured_s == clock.now_s()
    assert picture.within_s is not None
    with pytest.raises(eyes.SourceError, match="check its cable"):
        [camera.read() for _ in range(3)]
    camera.close()
    monkeypatch.setattr(eyes, "DEVICES", (films[0], "/nowhere"))
    with pytest.raises(eyes.SourceError, match="/nowhere cannot be opened"):
        camera.open()
    camera.close()


def test_a_lamp_is_switched(imported: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The lamp follows its control, but nothing from an earlier turn, and the wheels still turn."""
    pins = MockFactory(pin_class=MockPWMPin)
    monkeypatch.setattr(Device, "pin_factory", pins)
    imported("lamp")
    settings = configured("lamp.py")
    driver = make_driver(settings.robot, TurnedClock())
    check_controls(driver.limits, settings.robot.driver, settings.controls)
    assert isinstance(driver, HasControls)
    [lamp] = settings.controls
    driver.open()
    try:
        driver.control(lamp.name, True, 2)
        assert pins.pin(21).state
        driver.control(lamp.name, False, 1)
        assert pins.pin(21).state
        driver.control(lamp.name, False, 2)
        assert not pins.pin(21).state
    finally:
        driver.close()
        pins.reset()


async def test_a_receiver_prints_what_is_signed(tmp_path: Path) -> None:
    """It takes what `wax hook test` sends, once it is signed with the same secret just now."""
    path = EXAMPLES / "hook_receiver.py"
    port, secret = free_port(), secret_file(tmp_path)
    text = path.read_text(encoding="utf-8").replace("8090", str(port))
    settings = configured("hook_receiver.py", text.replace("/etc/wax/hook-secret", secret))
    other = tmp_path / "other-secret"
    other.write_text("whsec_" + "A" * 32)
    stranger = settings.hook[0].model_copy(update={"secret_file": str(other)})
    program = await asyncio.create_subprocess_exec(
        *(sys.executable, str(path), str(port), secret), stdout=PIPE, stderr=DEVNULL
    )
    said: list[str] = []
    try:
        until(lambda: is_open(port))
        assert await hook_test(settings, SystemClock(), said.append) == 0, said
        assert await hook_test(settings, TurnedClock(), said.append) == 1
        forged = settings.model_copy(update={"hook": [stranger]})
        assert await hook_test(forged, SystemClock(), said.append) == 1
    finally:
        program.kill()
        printed, _ = await program.communicate()
    assert ["401" in one for one in said] == [False, True, True]
    assert [line.split()[1:] for line in printed.splitlines()] == [[b"hook.test"]]


def is_open(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def test_a_reader_tells_how_far_turns_went(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It adds what each turn drove, sideways too, and counts what was refused."""
    path = tmp_path / "part.mcap"
    tape = EventFile(path, origin_s=10.0, zero_ns=10**18)
    turns = [(3, 0.5, 0.0, 10.0), (3, 0.0, 0.0, 14.0), (4, 0.3, 0.4, 20.0), (4, 0.0, 0.0, 22.0)]
    for turn, ahead, aside, at_s in turns:
        tape.write(steered(ahead, turn=turn, lateral_mps=aside), at_s)
    for why in ("stopped", None, "stopped", "too_old"):
        tape.write(commanded(held=True, refused=why), 15.0)
    tape.close()
    monkeypatch.setattr(sys, "argv", ["read_tape.py", str(path)])
    runpy.run_path(str(EXAMPLES / "read_tape.py"))
    assert capsys.readouterr().out.splitlines() == [
        "turn 3: 2.00 m",
        "turn 4: 1.00 m",
        "refused as stopped: 2",
        "refused as too_old: 1",
    ]
