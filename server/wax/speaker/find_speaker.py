"""Build the speaker that the configuration names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.driver.interface import HasSpeaker
from wax.errors import ConfigError
from wax.folders import expanded
from wax.named_file import check, problem
from wax.plugin import is_plugin_name, make_plugin
from wax.speaker.file import FileSpeaker
from wax.speaker.portaudio import PortAudioSpeaker

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.voice import VoiceSettings
    from wax.driver.interface import Driver
    from wax.speaker.interface import Speaker

_KEY: Final = "[voice] speaker"


def make_speaker(settings: VoiceSettings, clock: Clock, driver: Driver) -> Speaker | None:
    """Build the speaker without opening it; None if configured as ``none``.

    Raises `ConfigError` for a speaker that cannot work. A missing device is not an error, because
    it may be plugged in later.
    """
    name = settings.speaker
    if name == "none":
        return None
    if name == "robot":
        if not isinstance(driver, HasSpeaker):
            raise ConfigError(
                f"{_KEY}: the {driver.kind} robot has no speaker of its own; use none, speaker"
                " or a file that ends in .wav."
            )
        return driver.speaker(clock)
    kind, _, device = name.partition(":")
    if kind == "speaker":
        number_or_name = int(device) if device.isdecimal() else device or None
        return PortAudioSpeaker(settings, clock, device=number_or_name)
    if name.endswith(".wav"):
        return _file(name)
    if is_plugin_name(name):
        needs, contract = ("open", "write", "close"), "wax/speaker/interface.py"
        plugin: Speaker = make_plugin(name, _KEY, settings, clock, needs=needs, contract=contract)
        return plugin
    raise ConfigError(
        f"{_KEY}: got {name!r}; possible are none, robot, speaker, a device listed by"
        " 'wax devices', a file that ends in .wav, or your own class as 'package.module:Class'"
    )


def _file(name: str) -> FileSpeaker:
    path = expanded(name)
    if not path.parent.is_dir():
        raise ConfigError(f"{_KEY}: {path.parent.absolute()} is no folder; make it first.")
    try:
        check(path)
    except FileNotFoundError:
        pass  # it is created with the first word
    except OSError as error:
        raise ConfigError(f"{_KEY}: {path} {problem(error)}; name a file.") from error
    return FileSpeaker(path)
