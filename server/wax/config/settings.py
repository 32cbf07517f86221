"""The configuration: every key with its range and default; `config/wax.toml` is its manual."""

from __future__ import annotations

import tomllib
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from pydantic import Field, ValidationError, model_validator

from wax.config import driver_tables, foreign_table, problems
from wax.config.access import AccessSettings
from wax.config.audio import AudioSettings
from wax.config.camera import MAX_CAMERAS, CameraSettings
from wax.config.controls import (
    MAX_CONTROLS,
    MAX_GAUGES,
    ControlSettings,
    GaugeSettings,
    check_controls,
)
from wax.config.door import DoorSettings, check_server
from wax.config.drive import DriveSettings
from wax.config.hook import MAX_HOOKS, HookSettings, check_targets
from wax.config.local import LocalSettings
from wax.config.log import LogSettings
from wax.config.metrics import MetricSettings
from wax.config.mqtt import MqttSettings
from wax.config.network import NetworkSettings
from wax.config.page import PageSettings
from wax.config.proxy import check_believed
from wax.config.publish import PublishSettings
from wax.config.recording import RecordingSettings
from wax.config.records import RecordSettings
from wax.config.relay import RelaySettings
from wax.config.robot import RobotSettings
from wax.config.server import ServerSettings
from wax.config.stop import StopSettings
from wax.config.sync import RoleSyncSettings
from wax.config.table import ConfigTable, check_apart
from wax.config.thesis import ThesisSettings
from wax.config.turns import TurnSettings
from wax.config.video import DrivingViewSettings
from wax.config.voice import VoiceSettings
from wax.errors import ConfigError, reason_of
from wax.named_file import read_bytes

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from wax.config.allowed import Schema

_MOST_LEVELS: Final = 16
"""Twice the levels that the configuration has."""


class Settings(ConfigTable):
    """The manual of WAX's configuration: every key, with its default value. It is written from
    server/wax/config by `make manual`.

    Copy the keys you want to change into a file of your own and start with: wax --config FILE

    A name ends with its unit: _s seconds, _ms milliseconds, _hz times a second, _bps bits a second,
    _m metres, _mps metres a second, _rps radians a second. A relative file name is relative to the
    folder in which the server was started, not to that of the configuration.
    """

    publish: Annotated[list[PublishSettings], Field(max_length=16)] = []
    hook: Annotated[list[HookSettings], Field(max_length=MAX_HOOKS)] = []
    camera: Annotated[list[CameraSettings], Field(max_length=MAX_CAMERAS)] = []
    controls: Annotated[list[ControlSettings], Field(max_length=MAX_CONTROLS)] = []
    gauges: Annotated[list[GaugeSettings], Field(max_length=MAX_GAUGES)] = []
    server: ServerSettings = ServerSettings()
    page: PageSettings = PageSettings()
    access: AccessSettings = AccessSettings()
    log: LogSettings = LogSettings()
    records: RecordSettings = RecordSettings()
    recording: RecordingSettings = RecordingSettings()
    metrics: MetricSettings = MetricSettings()
    mqtt: MqttSettings = MqttSettings()
    network: NetworkSettings = NetworkSettings()
    relay: RelaySettings = RelaySettings()
    door: DoorSettings = DoorSettings()
    video: DrivingViewSettings = DrivingViewSettings()
    audio: AudioSettings = AudioSettings()
    voice: VoiceSettings = VoiceSettings()
    sync: RoleSyncSettings = RoleSyncSettings()
    thesis: ThesisSettings = ThesisSettings()
    turns: TurnSettings = TurnSettings()
    drive: DriveSettings = DriveSettings()
    stop: StopSettings = StopSettings()
    robot: RobotSettings = RobotSettings()
    local: LocalSettings = LocalSettings()

    @model_validator(mode="after")
    def _has_lines_of_its_own(self) -> Self:
        serial = self.local.source == "serial" and self.robot.driver == "serial"
        if serial and self.local.url == self.robot.serial.url:
            raise ValueError(
                f"local.url and robot.serial.url are both {self.local.url}; the hand control"
                " needs a line of its own"
            )
        return self

    @model_validator(mode="after")
    def _who_is_told_is_elsewhere(self) -> Self:
        server = self.server
        names = [server.host, *server.all_names]
        targets = [(f"hook[{number}].url", one.url) for number, one in enumerate(self.hook)]
        targets += [("mqtt.url", self.mqtt.url)] if self.mqtt.url else []
        lines = [self.robot.model_dump(), self.local.model_dump()]
        check_targets(targets, server.port, names, lines)
        return self

    @model_validator(mode="after")
    def _door_leads_here(self) -> Self:
        check_server(self.door, self.server)
        return self

    @model_validator(mode="after")
    def _believes_only_the_proxy(self) -> Self:
        check_believed(self.access.proxy, self.server, self.door.host)
        return self

    @model_validator(mode="after")
    def _controls_differ(self) -> Self:
        check_controls(self.controls, self.gauges, self.robot.lateral_mps)
        return self

    @model_validator(mode="after")
    def _cameras_differ(self) -> Self:
        names = [one.name for one in self.camera]
        check_apart("camera: two have the name {}; give each its own", names)
        axes = [axis for one in self.camera for axis in one.axes]
        check_apart("camera: two move with the axis {}; it can turn only one", axes)
        if self.camera and self.video.source == "none":
            raise ValueError(
                "camera: there is no driving view beside them; name it in [video] source"
            )
        return self

    @model_validator(mode="after")
    def _is_of_today(self) -> Self:
        if self.publish and self.sync.policy == "thesis":
            raise ValueError("publish has no use for the thesis's policy; leave one of them out")
        if self.camera and self.sync.policy == "thesis":
            raise ValueError(
                "the system of 2004 showed one picture; leave camera out, or set sync.policy to"
                " by-role"
            )
        if self.voice.speaker != "none" and self.sync.policy == "thesis":
            raise ValueError(
                "nobody spoke in the system of 2004; set [voice] speaker to none, or sync.policy to"
                " by-role"
            )
        if self.recording.enabled and self.sync.policy == "thesis":
            raise ValueError("recording cannot keep what the thesis's policy sends; leave one out")
        named = [one.name for one in self.publish]
        if len(set(named)) < len(named):
            raise ValueError("publish names a room twice; give each its own name in `room`")
        return self


def load(path: Path | None) -> Settings:
    """Load a TOML file; missing keys, or all if `path` is None, have their defaults.

    Raises `ConfigError` with the file's name and all its problems.
    """
    if path is None:
        return Settings()
    try:
        tree = tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {reason_of(error)}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not UTF-8 text; is it the right file?") from error
    except (ValueError, RecursionError) as error:  # also for huge numbers and deep nesting
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    if _is_deep(tree):  # dotted keys nest without the parser's recursion
        raise ConfigError(f"{path}: is nested more than {_MOST_LEVELS} levels deep")
    return parse(tree, str(path))


def _is_deep(tree: object) -> bool:
    """Whether it nests deeper than allowed; Python's own recursion limit varies by version."""
    level: list[Any] = [tree]
    for _ in range(_MOST_LEVELS):
        level = [
            inner
            for one in level
            for inner in (one.values() if isinstance(one, dict) else one)
            if isinstance(inner, dict | list)
        ]
    return bool(level)


def parse(tree: dict[str, Any], name: str) -> Settings:
    """Validate a parsed TOML tree; `name` is the file's name in messages.

    Raises `ConfigError` with one line for each wrong key: its value and what is allowed.
    """
    settings, lines = None, list[str]()
    try:
        settings = Settings.model_validate(tree)
    except ValidationError as error:
        lines = problems.lines(error, _schema())
    lines += _own_tables(tree.get("robot"))
    if settings is None or lines:
        count = f"{len(lines)} problem" + ("s" if len(lines) > 1 else "")
        raise ConfigError("\n  ".join([f"{name}: {count}:", *lines]))
    return settings


def _own_tables(robot: object) -> list[str]:
    """Validate the drivers' own tables."""
    ours = RobotSettings.model_fields
    if not isinstance(robot, dict) or not driver_tables.tables(robot, ours):
        return []
    if driver_tables.is_ours(robot):
        return driver_tables.check_here(robot, ours=ours)
    return foreign_table.check(robot, ours)


def describe_drivers(names: Sequence[str]) -> list[str]:
    """Return the manual's lines for these drivers' tables, or for all that are installed.

    Raises `ConfigError` for an unknown driver.
    """
    return driver_tables.describe(names, ours=RobotSettings.model_fields)


@cache
def _schema() -> Schema:
    return Settings.model_json_schema()
