"""Checks camera, microphone and serial port: each is opened, read once, and closed."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import serial

from wax.capture.file.address import is_network, shown_name
from wax.capture.find_sources import Sources, make_camera, make_sources
from wax.capture.source import Picture, Sound
from wax.capture.undated import undated
from wax.clock import SystemClock
from wax.commands.doctor.verdict import Verdict, bad, ok, warning
from wax.errors import ConfigError, SourceError
from wax.robot.find_driver import make_driver
from wax.robot.serial.advice import advised
from wax.robot.serial.list_ports import find_ports, safer_name
from wax.robot.serial.port_line import why_not_open

if TYPE_CHECKING:
    from wax.config.camera import CameraSettings
    from wax.config.serial import SerialSettings
    from wax.config.settings import Settings

_PIECES: Final = 20
"""A microphone's first blocks may be empty."""
_DATED_S: Final = 2.0
_BUSY: Final = "Stop the server to check it here, or look at the page, which says how it is."


def camera(settings: Settings, *, running: bool) -> Verdict:
    """Open the camera and wait for a picture."""
    name = _shown(settings.video.source)
    if name == "none":
        return ok("There is no camera, as configured.")
    if running:
        return warning(f"The camera {name} was not tried: WAX is running.", _BUSY)
    return _delivers(settings, "camera", name)


def further_camera(settings: Settings, one: CameraSettings, *, running: bool) -> Verdict:
    """Open a camera other than the driving view and wait for a picture."""
    if running:
        return warning(f"The camera {one.name} was not tried: WAX is running.", _BUSY)
    try:
        clock = SystemClock()
        source = make_camera(one, clock, make_driver(settings.robot, clock))
        try:
            source.open()
            first = source.read()
        finally:
            source.close()
    except ConfigError as error:
        return bad(str(error), f"Correct the table [[camera]] of {one.name}.")
    except SourceError as error:
        return bad(f"{one.name}: {error}", "Or give it another source of `wax devices`.")
    return ok(f"The camera {one.name} gives pictures of {first.width}×{first.height}.")


def microphone(settings: Settings, *, running: bool) -> Verdict:
    """Open the microphone and listen for a moment."""
    name = _shown(settings.audio.source)
    if name == "none":
        return ok("There is no microphone, as configured.")
    if running:
        return warning(f"The microphone {name} was not tried: WAX is running.", _BUSY)
    return _delivers(settings, "microphone", name)


def _delivers(settings: Settings, what: str, name: str) -> Verdict:
    key = "video.source" if what == "camera" else "audio.source"
    try:
        sources = _sources(settings, what)
        source: Any = sources.video if what == "camera" else sources.audio
        if source is None:
            return warning(
                "No microphone was found, so there is no sound.",
                'Plug one in, or write [audio] source = "none" if there shall be none.',
            )
        began_s = time.monotonic()
        try:
            source.open()
            first = source.read()
            took_s = time.monotonic() - began_s
            if name == "auto":
                name = _shown(getattr(source, "name", "robot"))
            if isinstance(first, Picture):
                if not _is_dated(source, first):
                    return warning(
                        f"The camera {name} gives pictures of {first.width}×{first.height}.",
                        str(undated(settings.video.source)),
                    )
                return ok(
                    f"The camera {name} gives pictures of {first.width}×{first.height};"
                    f" the first came after {took_s:.1f} s."
                )
            return _heard(name, first, source)
        finally:
            source.close()
    except ConfigError as error:
        return bad(str(error), f"Correct {key} or robot.driver.")
    except SourceError as error:
        return bad(str(error), f"Or set {key} to another one of `wax devices`.")


def _is_dated(source: Any, first: Picture) -> bool:
    """Whether the pictures' age is known; a stream's is unknown at the beginning."""
    end_s = time.monotonic() + _DATED_S
    while first.within_s is None and time.monotonic() < end_s:
        first = source.read()
    return first.within_s is not None


def _sources(settings: Settings, what: str) -> Sources:
    """Build only the source under test, so that a fault of the other is not reported twice."""
    clock = SystemClock()
    other = {"source": "none"}
    video = settings.video if what == "camera" else settings.video.model_copy(update=other)
    audio = settings.audio if what == "microphone" else settings.audio.model_copy(update=other)
    taken = [one.source for one in settings.camera]
    return make_sources(video, audio, clock, make_driver(settings.robot, clock), taken)


def _shown(source: str) -> str:
    """Return a source's name as a sentence has it, without a password."""
    if source == "robot":
        return "of the robot"
    return shown_name(source) if is_network(source) else source


def _heard(name: str, first: Sound, source: Any) -> Verdict:
    pieces = [first, *(source.read() for _ in range(_PIECES))]
    both = np.concatenate([piece.with_channels(2).samples for piece in pieces])
    # A constant signal counts as silence: a cheap sound card gives one even when it is muted.
    moves = np.ptp(both, axis=0).astype(bool)
    if not moves.any():
        return warning(
            f"The microphone {name} gives no sound at all, not even noise.",
            "Check that it is not muted: `alsamixer`, F4 for capture.",
        )
    if all(piece.channels == 1 for piece in pieces):
        return ok(f"The microphone {name} gives sound, in mono.")
    for side, one_moves in zip(("left", "right"), moves, strict=True):
        if not one_moves:
            return warning(
                f"The {side} channel of the microphone {name} gives no sound at all.",
                "Check its cable and its capsule; both ears get the other channel meanwhile.",
            )
    return ok(f"The microphone {name} gives sound, in stereo.")


def serial_port(settings: Settings, *, running: bool) -> Verdict:
    """Open and close the robot's serial port without sending a byte."""
    robot = settings.robot
    if robot.driver != "serial":
        return ok(f"The {robot.driver} robot needs no serial port of [robot.serial].")
    if running:
        return warning(f"{robot.serial.url} was not tried: WAX is running.", _BUSY)
    try:
        _open(robot.serial)
    except Exception as error:
        # The handlers of pyserial's URLs raise all sorts of exceptions.
        problem, _, advice = str(why_not_open(robot.serial.url, error)).partition(": ")
        return bad(f"{problem}.", advice[:1].upper() + advice[1:])
    worst = next(iter(advised(robot.serial)), None)
    if worst is not None:
        return warning(f"{worst.problem}.", f"{worst.remedy}.")
    safer = safer_name(robot.serial.url, find_ports())
    if safer is not None:
        return warning(
            f"{robot.serial.url} may be another board after a restart: several are plugged in.",
            f'Write [robot.serial] url = "{safer}".',
        )
    return ok(
        f"The serial port {robot.serial.url} opens. Whether the robot obeys, and how fast it stops,"
        " `wax prove-stop` finds out."
    )


def _open(settings: SerialSettings) -> None:
    port = serial.serial_for_url(settings.url, do_not_open=True, exclusive=True)
    port.baudrate = settings.baud
    port.dtr = False  # at which many boards restart
    port.open()
    port.close()
