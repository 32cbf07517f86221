"""A robot's camera, microphone and speaker, in another process than its driver."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.examples import at_length
from tests.robot.media import sighted
from tests.robot.process.conftest import Log, is_alive
from tests.until import until

from wax.clock import SystemClock
from wax.config.camera import CameraSettings
from wax.config.robot import RobotSettings
from wax.config.serial import SerialSettings
from wax.config.video import VideoSettings
from wax.driver.interface import (
    STANDSTILL,
    HasCamera,
    HasExternalView,
    HasMicrophone,
    HasSpeaker,
    KnowsItsView,
)
from wax.errors import SourceError, SpeakerError
from wax.robot.known import Known, look
from wax.robot.media.process import STUCK_S, MediaProcess
from wax.robot.sensing_driver import SensingDriver

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from wax.capture.source import AudioSource, Picture, VideoSource
    from wax.speaker.interface import Speaker

pytestmark = pytest.mark.system

SMALL = VideoSettings(width=64, height=48, fps=60)
PATIENCE_S = 20.0


@pytest.fixture
def log(tmp_path: Path) -> Log:
    return Log(tmp_path / "log")


@pytest.fixture
def made(log: Log) -> Iterator[Callable[[str], SensingDriver]]:
    """Make the robot of this name; close it after the test."""
    robots: list[SensingDriver] = []

    def make(name: str) -> SensingDriver:
        settings = RobotSettings(
            driver=f"tests.robot.media.sighted:{name}",
            serial=SerialSettings(url=str(log._path)),
        )
        known = Known.of(getattr(sighted, name)(settings, SystemClock()), settings)
        media = MediaProcess(settings)
        robots.append(SensingDriver(settings, SystemClock(), known=known, media=media))
        return robots[-1]

    yield make
    for robot in robots:
        robot.close()
        robot._media.close(3.0)


@pytest.fixture
def robot(made: Callable[[str], SensingDriver]) -> SensingDriver:
    return made("Sighted")


def camera(robot: SensingDriver) -> VideoSource:
    assert isinstance(robot, HasCamera)
    return robot.camera(SMALL, SystemClock())


def microphone(robot: SensingDriver) -> AudioSource:
    assert isinstance(robot, HasMicrophone)
    return robot.microphone(SystemClock())


def speaker(robot: SensingDriver) -> Speaker:
    assert isinstance(robot, HasSpeaker)
    return robot.speaker(SystemClock())


def first(source: VideoSource) -> Picture:
    """Open it and return the first picture, once the process has started."""
    source.open()
    end_s = time.monotonic() + PATIENCE_S
    while True:
        try:
            return source.read()
        except SourceError:
            assert time.monotonic() < end_s
            time.sleep(0.02)


def problem(source: VideoSource | AudioSource) -> str:
    """Return the next error instead of a picture."""
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        try:
            source.read()
        except SourceError as error:
            return str(error)
    raise AssertionError("it delivers")


def test_pictures_arrive_whole_in_order_and_with_their_times(robot: SensingDriver) -> None:
    """No picture is torn, repeated or changed later.

    A slow reader gets the newest; the external view has its own settings.
    """
    assert isinstance(robot, HasExternalView)
    above = CameraSettings(name="above", width=32, height=32, fps=60)
    source, view = camera(robot), robot.external_view(above, SystemClock())
    began_s = SystemClock().now_s()
    kept = first(source)
    number = int(kept.i420[0, 0])
    pictures = [source.read() for _ in range(60)]
    assert {picture.i420.shape for picture in pictures} == {(72, 64)}
    assert all(np.ptp(picture.i420) == 0 for picture in pictures)
    times = [picture.captured_s for picture in pictures]
    assert times == sorted(set(times))
    assert began_s < times[-1] <= SystemClock().now_s()
    assert int(kept.i420[0, 0]) == number
    assert first(view).i420.shape == (48, 32)
    before = source.read()
    time.sleep(0.5)
    after = source.read()
    assert (int(after.i420[0, 0]) - int(before.i420[0, 0])) % 250 > 1
    assert after.captured_s - before.captured_s > 0.25


def test_it_has_the_senses_of_the_driver_and_no_other(
    robot: SensingDriver, made: Callable[[str], SensingDriver]
) -> None:
    """It has exactly the driver's capabilities."""
    for sense in (HasCamera, HasExternalView, HasMicrophone, HasSpeaker, KnowsItsView):
        assert isinstance(robot, sense)
    assert robot.own_view.width_m == 0.4
    settings = RobotSettings(driver="tests.robot.media.sighted:Sighted")
    known = look(settings)  # in a process, as the server does
    assert known == Known.of(sighted.Sighted(settings, SystemClock()), settings)
    assert not isinstance(made("Recorder"), HasCamera | HasMicrophone | HasSpeaker | KnowsItsView)


def test_sound_comes_in_order_on_its_channels(robot: SensingDriver) -> None:
    """No block is missing or torn, the channels are kept apart, and old sound is dropped."""
    source = microphone(robot)
    source.open()
    until(lambda: not _fails(source))
    blocks, read_s = [], [time.monotonic()]
    for _ in range(50):
        blocks.append(source.read())
        read_s.append(time.monotonic())
    numbers = [int(block.samples[0, 0]) for block in blocks]
    for step, pauses_s in zip(np.diff(numbers), pairwise(np.diff(read_s)), strict=True):
        # A gap is allowed only where this process itself was delayed.
        assert step == 1 or (step > 1 and max(pauses_s) > 0.1)
    assert all(np.array_equal(block.samples[:, 0], -block.samples[:, 1]) for block in blocks)
    assert {block.samples.shape for block in blocks} == {(480, 2)}
    time.sleep(1.0)
    assert source.read().captured_s - blocks[-1].captured_s > 0.5


def _opens(mouth: Speaker) -> bool:
    try:
        mouth.open()
    except SpeakerError:
        return False
    return True


def _fails(source: AudioSource) -> bool:
    try:
        source.read()
    except SourceError:
        return True
    return False


def test_a_voice_is_played(robot: SensingDriver, log: Log) -> None:
    """All sound arrives in order, and the speaker's own error is raised."""
    mouth = speaker(robot)
    until(lambda: _opens(mouth))
    for number in range(5):
        mouth.write(np.full(480, number, np.int16))
    with pytest.raises(SpeakerError, match="an unlucky number"):
        mouth.write(np.full(480, 13, np.int16))
    mouth.write(np.full(5760, 6, np.int16))
    mouth.close()
    said = log._path.with_suffix(".said").read_text().splitlines()
    assert said == [*(f"480 {number}" for number in range(5)), "5760 6"]


def test_a_killed_process_is_restarted(robot: SensingDriver, log: Log) -> None:
    """The camera reports it, and the driver, in another process, is not affected.

    The server is a third process, and only the driver's process opens the robot.
    """
    source = camera(robot)
    first(source)
    robot.open()
    until(lambda: robot.state().connected)
    killed, driver = (int(robot.state().extra[f"{which}_pid"]) for which in ("media", "driver"))
    assert len({os.getpid(), killed, driver}) == 3
    assert [entry.values for entry in log.entries() if entry.word == "open"] == [(driver,)]
    os.kill(killed, signal.SIGKILL)
    assert problem(source) == (
        "The process of the robot's camera and sound has ended (signal 9); restarting it."
    )
    first(source)
    state = robot.state()
    assert state.extra["media_pid"] != killed
    assert state.extra["media_restarts"] == 1
    assert (state.connected, state.extra["driver_restarts"]) == (True, 0)


def test_a_frozen_process_is_replaced(robot: SensingDriver) -> None:
    """A process without heartbeats is replaced."""
    source = camera(robot)
    first(source)
    frozen = int(robot.state().extra["media_pid"])
    os.kill(frozen, signal.SIGSTOP)
    assert "delivers nothing" in problem(source)
    until(lambda: robot.state().extra.get("media_restarts") == 1)
    first(source)
    assert not is_alive(frozen)


@pytest.mark.alone
def test_the_process_ends_with_the_robot(robot: SensingDriver) -> None:
    """It ends within 1 s, and can restart."""
    source = camera(robot)
    first(source)
    pid = int(robot.state().extra["media_pid"])
    start_s = time.monotonic()
    robot.close()
    assert time.monotonic() - start_s < 1.0
    until(lambda: not is_alive(pid))
    first(source)


def says(source: VideoSource, what: str) -> Callable[[], bool]:
    return lambda: what in problem(source)


WILLS = {
    "raise": "The camera failed: no lens",
    "odd": "The camera delivers 64 by 71 bytes; it must be a Picture",
    "large": "The camera delivers 4096 by 4096 pixels; it must be a Picture",
    "none": "The camera delivers a NoneType that is no Picture; it must be",
    "exit": "has ended (status 3, see the server's log); restarting it.",
    "die": "has ended (signal 9); restarting it.",
    "hang": "The camera delivers nothing; check that it is connected.",
}


@pytest.mark.parametrize("wills", [("raise", "exit", "hang"), *at_length((tuple(WILLS),))])
def test_a_camera_that_fails_is_a_problem_and_recovers(
    made: Callable[[str], SensingDriver], log: Log, wills: tuple[str, ...]
) -> None:
    """Whatever the camera does, sound and driving continue, or return with their process."""
    robot = made("Wilful")
    source, ear = camera(robot), microphone(robot)
    first(source)
    robot.open()
    until(lambda: robot.state().connected)

    def is_driven() -> bool:
        robot.apply(STANDSTILL, 1)  # a busy machine may have been silent for too long
        return (robot.state().connected, robot.state().problem) == (True, None)

    for will in wills:
        restarts = robot.state().extra["media_restarts"]
        log._path.with_suffix(".will").write_text(will)
        until(says(source, WILLS[will]))
        log._path.with_suffix(".will").unlink()
        for _ in range(20):
            robot.apply(STANDSTILL, 1)
            time.sleep(0.02)
        until(is_driven)
        until(lambda: not _fails(ear))
        state = robot.state()
        assert state.extra["driver_restarts"] == 0
        has_ended = state.extra["media_restarts"] > restarts
        assert has_ended == (will in ("exit", "die")), will
        if will != "hang":
            first(source)


@pytest.mark.full
@pytest.mark.parametrize("is_heard", [True, False])
def test_a_camera_that_hangs_gets_a_new_process_unless_sound_works(
    made: Callable[[str], SensingDriver], log: Log, is_heard: bool
) -> None:
    """Its process is replaced, unless the microphone in it still delivers."""
    robot = made("Wilful")
    source, ear = camera(robot), microphone(robot)
    first(source)
    log._path.with_suffix(".will").write_text("hang")
    until(lambda: "delivers nothing" in problem(source))
    log._path.with_suffix(".will").unlink()
    end_s = time.monotonic() + STUCK_S + 6.0
    while time.monotonic() < end_s:
        with contextlib.suppress(SourceError):
            (ear if is_heard else source).read()
        if is_heard:
            with contextlib.suppress(SourceError):
                source.read()
        if robot.state().extra.get("media_restarts", 0):
            break
    assert robot.state().extra.get("media_restarts", 0) == (not is_heard)
    if not is_heard:
        first(source)
