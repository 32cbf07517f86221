"""Build the sources that the configuration names."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import structlog

from wax.capture.camera import OpenCvCamera
from wax.capture.file.address import is_network, open_container, shown_name
from wax.capture.file.media_file import MediaFile
from wax.capture.first_found import FirstCamera, first_microphone
from wax.capture.microphone import PortAudioMicrophone
from wax.capture.picamera import PiCamera
from wax.capture.upright import upright
from wax.driver.interface import HasCamera, HasExternalView, HasMicrophone
from wax.errors import ConfigError, SourceError
from wax.folders import expanded
from wax.named_file import check, problem
from wax.plugin import CAMERAS, MICROPHONES, is_plugin, make_plugin

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from wax.capture.file.address import Transport
    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.audio import AudioSettings
    from wax.config.camera import CameraSettings
    from wax.config.video import VideoSettings
    from wax.driver.interface import Driver

_LOG = structlog.get_logger(__name__)

_VIDEO_KEY: Final = "[video] source"
_AUDIO_KEY: Final = "[audio] source"


@dataclass(frozen=True, slots=True)
class Sources:
    """The camera and the microphone; None if configured as ``none``."""

    video: VideoSource | None
    audio: AudioSource | None


def make_sources(
    video: VideoSettings,
    audio: AudioSettings,
    clock: Clock,
    driver: Driver,
    taken: Iterable[str] = (),
) -> Sources:
    """Build both sources; no device or address is opened yet.

    `taken` are the sources of the other cameras, which "auto" does not choose.

    Picture and sound from the same file or address share one demuxer. Raises `ConfigError` for a
    source that cannot work, such as a missing file; a missing device is not an error, because it
    may be plugged in later.
    """
    files = _Files(clock)
    found = _make_video(video, clock, driver, files, taken)
    return Sources(
        video=None if found is None else upright(found, video),
        audio=_make_audio(audio, clock, driver, files),
    )


def make_camera(settings: CameraSettings, clock: Clock, driver: Driver) -> VideoSource:
    """Build the source of a camera other than the driving view, as `make_sources` does."""
    unknown = next((axis for axis in settings.axes if axis not in driver.limits.axes), None)
    if unknown is not None and getattr(driver, "is_known", True):  # otherwise its axes are unknown
        there = ", ".join(driver.limits.axes) or "none"
        raise ConfigError(
            f"camera {settings.name}: axes: the {driver.kind} robot has no axis {unknown}; its axes"
            f" are: {there}."
        )
    key = f"camera {settings.name}: source"
    if settings.source == "robot":
        if not isinstance(driver, HasExternalView):
            raise ConfigError(
                f"{key}: the {driver.kind} robot has no view of itself from outside; use testcard"
                " or a camera's number."
            )
        return upright(driver.external_view(settings, clock), settings)
    return upright(_find_video(settings, key, clock, _Files(clock)), settings)


def warn_of_shared_addresses(video: str, audio: str, cameras: Iterable[CameraSettings]) -> None:
    """Log an address that several tables open; most RTSP cameras serve several clients at once."""
    users: dict[str, list[str]] = {}
    tables = {"[video]": video, **{f"[[camera]] {one.name}": one.source for one in cameras}}
    if audio != video:
        tables["[audio]"] = audio
    for table, source in tables.items():
        users.setdefault(source, []).append(table)
    for source, names in users.items():
        if is_network(source) and len(names) > 1:
            _LOG.warning(
                "one address for several tables, each of which opens it: where only the first to"
                " come has a picture, the camera serves one client at a time",
                address=shown_name(source),
                tables=names,
            )


def _make_video(
    settings: VideoSettings,
    clock: Clock,
    driver: Driver,
    files: _Files,
    taken: Iterable[str],
) -> VideoSource | None:
    if settings.source == "none":
        return None
    if settings.source == "auto" and not isinstance(driver, HasCamera):

        def named(name: str) -> VideoSource:
            one = settings.model_copy(update={"source": name})
            return _find_video(one, _VIDEO_KEY, clock, files)

        return FirstCamera(named, taken=taken)
    if settings.source in ("auto", "robot"):
        if not isinstance(driver, HasCamera):
            raise ConfigError(_lacks_device(_VIDEO_KEY, driver.kind, "camera", "a camera's number"))
        return driver.camera(settings, clock)
    return _find_video(settings, _VIDEO_KEY, clock, files)


def _find_video(settings: VideoSettings, key: str, clock: Clock, files: _Files) -> VideoSource:
    name = settings.source
    device = camera_device(name)
    if device is not None:
        return OpenCvCamera(settings, clock, device=device)
    if name.startswith("picamera:"):
        return PiCamera(settings, clock)
    if not is_network(name) and is_plugin(name, CAMERAS, key):
        plugin: VideoSource = _make_plugin(name, key, settings, clock, CAMERAS)
        return plugin
    if settings.controls:
        raise ConfigError(
            f"{key.removesuffix('source')}controls: {shown_name(name)} has none; they are a"
            " camera's at this machine, as 'wax devices' lists them."
        )
    return files.find(name, key, settings.rtsp_transport).video(settings)


def _make_audio(
    settings: AudioSettings, clock: Clock, driver: Driver, files: _Files
) -> AudioSource | None:
    settings = _found_for(settings, driver)
    name = settings.source
    if name == "none":
        return None
    if name == "robot":
        if not isinstance(driver, HasMicrophone):
            raise ConfigError(_lacks_device(_AUDIO_KEY, driver.kind, "microphone", "microphone"))
        return driver.microphone(clock)
    microphone = _microphone(settings, clock)
    if microphone is not None:
        return microphone
    if not is_network(name) and is_plugin(name, MICROPHONES, _AUDIO_KEY):
        plugin: AudioSource = _make_plugin(name, _AUDIO_KEY, settings, clock, MICROPHONES)
        return plugin
    return files.find(name, _AUDIO_KEY).audio(settings)


def _found_for(settings: AudioSettings, driver: Driver) -> AudioSettings:
    """Return the settings with "auto" replaced by the microphone that was found."""
    if settings.source != "auto":
        return settings
    if isinstance(driver, HasMicrophone):
        return settings.model_copy(update={"source": "robot"})
    found = first_microphone()
    return settings.model_copy(update={"source": "none" if found is None else found.source})


def _microphone(settings: AudioSettings, clock: Clock) -> AudioSource | None:
    """Return the named microphone, or None if the name is not a microphone's."""
    kind, _, device = settings.source.partition(":")
    if kind == "alsa" and device:
        raise ConfigError(
            f"{_AUDIO_KEY}: {settings.source} is now {_named_by_portaudio(device)}; "
            "'wax devices' lists what is there."
        )
    if kind != "microphone":
        return None
    number_or_name = int(device) if device.isdecimal() else device or None
    return PortAudioMicrophone(settings, clock, device=number_or_name)


def _named_by_portaudio(alsa: str) -> str:
    """Return PortAudio's name for a device that is configured by its ALSA name.

    PortAudio matches part of a device's name, which contains the card's number but not its id.
    """
    match = re.fullmatch(r"(?:plug)?hw:(\d+)(?:,(\d+))?", alsa)
    if match is None:
        return "microphone:… with a part of the device's name, or microphone for the default"
    return f'"microphone:hw:{match[1]},{match[2] or 0}"'


class _Files:
    """The media files built so far, so that a file that is named twice is opened once."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._files: dict[str, MediaFile] = {}

    def find(self, name: str, key: str, transport: Transport = "auto") -> MediaFile:
        address = name if is_network(name) else str(_existing(name, key))
        made = MediaFile(address, self._clock, transport=transport)
        return self._files.setdefault(address, made)


def camera_device(name: str) -> int | str | None:
    """Return a camera's number or path, or None if the name is not a camera's.

    Without ``camera:`` a path counts as a camera only if it cannot be a media file.
    """
    device = name.removeprefix("camera:")
    if device.isdecimal():
        return int(device)
    prefixes = ("/dev/video", "/dev/v4l/") if device == name else ("/",)
    return device if device.startswith(prefixes) else None


def _existing(name: str, key: str) -> Path:
    path = expanded(name)
    try:
        check(path)
        open_container(str(path)).close()
    except OSError as error:
        raise ConfigError(
            f"{key}: {name} {problem(error)} (looked for {path.absolute()}); use a file, an"
            " address, a device listed by 'wax devices', auto, testcard, robot, none or"
            " package.module:Class."
        ) from error
    except SourceError as error:
        raise ConfigError(f"{key}: {error}") from error
    return path.resolve()


def _make_plugin(
    name: str, key: str, settings: VideoSettings | AudioSettings, clock: Clock, group: str
) -> Any:
    """Build a plug-in source and check that it has a source's methods."""
    needs, contract = ("open", "read", "close"), "wax/capture/source.py"
    return make_plugin(name, key, settings, clock, needs=needs, contract=contract, group=group)


def _lacks_device(key: str, kind: str, device: str, instead: str) -> str:
    return f"{key}: the {kind} robot has no {device} of its own; use none, testcard or {instead}."
