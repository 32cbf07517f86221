"""The configuration: every key with its range and default; `config/wax.toml` is its manual."""

from __future__ import annotations

import tomllib
import zoneinfo
from functools import cache
from ipaddress import ip_address
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self, TypeVar
from urllib.parse import urlsplit

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from wax.config import driver_tables, foreign_table, opening_hours, problems
from wax.config.addresses import ONE_HOST, HostName, IpAddress, Network, PageUrl, StunUrl, TurnUrl
from wax.config.controls import (
    MAX_CONTROLS,
    MAX_GAUGES,
    ControlSettings,
    GaugeSettings,
    check_apart,
    check_names,
)
from wax.config.door import DoorSettings, check_server
from wax.config.hook import MAX_HOOKS, HookSettings, check_targets
from wax.config.mqtt import MqttSettings
from wax.config.page import PageSettings
from wax.config.publish import PublishSettings
from wax.config.recording import RecordingSettings
from wax.config.text_dialect import TextDialectSettings
from wax.config.thesis import ThesisSettings
from wax.errors import ConfigError, reason_of
from wax.named_file import read_bytes

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from wax.config.allowed import Schema
    from wax.config.driver_settings import DriverSettings


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class ServerSettings(_Section):
    """`[server]`: where the page is served, and to how many viewers."""

    host: Annotated[str, Field(min_length=1), ONE_HOST] = "localhost"
    port: Annotated[int, Field(ge=0, le=65535)] = 8080
    max_viewers: Annotated[int, Field(ge=1, le=1000)] = 100
    state_dir: str = ""
    max_share_per_address: Annotated[float, Field(gt=0, le=1)] = 0.5
    max_offers_per_address_hz: Annotated[float, Field(gt=0, le=1000)] = 2.0
    max_silent_per_address: Annotated[int, Field(ge=1, le=1000)] = 2
    names: list[HostName] = []
    public_url: PageUrl = ""
    trusted_proxies: list[Network] = []
    https: bool = False
    certificate: str = ""
    key: str = ""
    max_connections: Annotated[int, Field(ge=16, le=100_000)] = 640
    max_connections_per_address: Annotated[int, Field(ge=4, le=100_000)] = 64

    @property
    def all_names(self) -> list[str]:
        """`names`, and that of the public page."""
        public = urlsplit(self.public_url).hostname
        return [*self.names, *([public] if public else [])]

    @model_validator(mode="after")
    def _certificate_has_its_key(self) -> Self:
        if bool(self.certificate) != bool(self.key):
            missing = "key" if self.certificate else "certificate"
            raise ValueError(f"certificate and key belong together; {missing} is missing")
        return self


class AccessSettings(_Section):
    """`[access]`: who is admitted, and what strangers may do."""

    strangers_watch: bool = True
    strangers_hear: bool = True
    strangers_queue: bool = True
    max_tabs: Annotated[int, Field(ge=1, le=100)] = 4
    hours: list[
        Annotated[
            str,
            Field(
                pattern=opening_hours.PATTERN,
                description='days and times as "mon-fri 09:00-18:00"',
                json_schema_extra={"plural": "hours"},
            ),
        ]
    ] = []
    time_zone: str = "UTC"

    @field_validator("time_zone")
    @classmethod
    def _is_known(cls, name: str) -> str:
        known = zoneinfo.available_timezones()
        if name == "UTC" or name in known:
            return name
        if not known:
            raise ValueError(
                f"{name} needs time zone data, which this machine lacks: install Python's package"
                " tzdata, or leave the key out for UTC"
            )
        raise ValueError(f"there is no time zone {name}; one is Europe/Berlin")


class LogSettings(_Section):
    """`[log]`."""

    format: Literal["text", "json"] = "text"
    level: Literal["debug", "info", "warning", "error"] = "info"


class RecordSettings(_Section):
    """`[records]`: what is recorded, and for how long."""

    enabled: bool = True
    path: str = ""
    keep_days: Annotated[float, Field(ge=0.01, le=3650)] = 30.0


class MetricSettings(_Section):
    """`[metrics]`: where Prometheus scrapes them."""

    port: Annotated[int, Field(ge=0, le=65535)] = 0
    host: Annotated[str, Field(min_length=1)] = "localhost"


class NetworkSettings(_Section):
    """`[network]`: how picture, sound and commands reach the viewers."""

    mode: Literal["one-port", "full-ice"] = "one-port"
    udp_port: Annotated[int, Field(ge=0, le=65535)] = 8081
    public_addresses: Annotated[list[IpAddress], Field(max_length=4)] = []
    interfaces: Annotated[list[Annotated[str, Field(min_length=1)]], Field(max_length=16)] = []
    stun: Annotated[list[StunUrl], Field(max_length=4)] = []
    upload_bps: Annotated[int, Field(ge=0, le=10_000_000_000)] = 0

    @field_validator("public_addresses")
    @classmethod
    def _are_addresses(cls, addresses: list[str]) -> list[str]:
        found = []
        for address in addresses:
            try:
                found.append(str(ip_address(address)))
            except ValueError:
                raise ValueError(
                    f"{address} is no address; write it as 203.0.113.7 or 2001:db8::7"
                ) from None
        return found


class RelaySettings(_Section):
    """`[relay]`: a TURN server for viewers whose network blocks UDP; none by default."""

    urls: Annotated[list[TurnUrl], Field(max_length=4)] = []
    secret: Annotated[str, Field(repr=False)] = ""
    secret_file: str = ""
    only: bool = False

    @model_validator(mode="after")
    def _has_what_it_needs(self) -> Self:
        if self.secret and self.secret_file:
            raise ValueError("there are a secret and a secret_file; leave one of them out")
        if self.urls and not (self.secret or self.secret_file):
            raise ValueError(
                "there are urls without a secret; name the file that holds the TURN server's"
                " static-auth-secret in secret_file"
            )
        if self.only and not self.urls:
            raise ValueError("only = true needs urls, the addresses of a TURN server")
        return self


class RenditionSettings(_Section):
    """One size of the picture, encoded once for all its viewers."""

    width: Annotated[int, Field(ge=32, le=3840, multiple_of=2)]
    height: Annotated[int, Field(ge=32, le=2160, multiple_of=2)]
    fps: Annotated[float, Field(ge=1, le=60)]
    bitrate_bps: Annotated[int, Field(ge=10_000, le=20_000_000)]

    @property
    def size(self) -> str:
        """The size, which a viewer can choose."""
        return f"{self.width}x{self.height}"

    @property
    def name(self) -> str:
        """A name that tells it from others of the same size."""
        return f"{self.size} at {self.bitrate_bps / 1000:g} kbit/s"


MIN_FOV_DEG: Final = 10.0
MIN_CAMERA_HEIGHT_M: Final = 0.02
MAX_CAPTURE_FPS: Final = 240.0
"""The maximum of a camera; a rendition has at most 60."""


class VideoSettings(_Section):
    """A camera: the keys that `[video]` and `[[camera]]` share."""

    source: Annotated[str, Field(min_length=1)] = "robot"
    width: Annotated[int, Field(ge=32, le=3840, multiple_of=2)] = 640
    height: Annotated[int, Field(ge=32, le=2160, multiple_of=2)] = 480
    fps: Annotated[float, Field(ge=1, le=MAX_CAPTURE_FPS)] = 30.0
    rotate: Literal[0, 90, 180, 270] = 0
    mirror: bool = False
    controls: Annotated[dict[str, bool | int | float], Field(max_length=32)] = {}
    rtsp_transport: Literal["auto", "tcp", "udp"] = "auto"
    codec: Literal["vp8", "h264"] = "vp8"
    encoder: Literal["auto", "software", "h264_nvenc", "h264_qsv", "h264_amf", "h264_v4l2m2m"] = (
        "auto"
    )
    keyframe_interval_s: Annotated[float, Field(ge=0.5, le=60)] = 10.0
    timestamp_overlay: bool = False
    renditions: Annotated[list[RenditionSettings], Field(min_length=1, max_length=8)] = [
        RenditionSettings(width=640, height=480, fps=30.0, bitrate_bps=1_000_000),
        RenditionSettings(width=640, height=480, fps=30.0, bitrate_bps=600_000),
        RenditionSettings(width=320, height=240, fps=30.0, bitrate_bps=300_000),
        RenditionSettings(width=320, height=240, fps=15.0, bitrate_bps=120_000),
        RenditionSettings(width=160, height=120, fps=15.0, bitrate_bps=50_000),
        RenditionSettings(width=160, height=120, fps=10.0, bitrate_bps=16_000),
    ]

    @property
    def is_turned(self) -> bool:
        """Whether the picture is rotated or mirrored."""
        return self.rotate != 0 or self.mirror

    @property
    def upright_size(self) -> tuple[int, int]:
        """Width and height of a picture after rotation."""
        lies = self.rotate % 180 != 0
        return (self.height, self.width) if lies else (self.width, self.height)

    @model_validator(mode="before")
    @classmethod
    def _ladder_turns_too(cls, given: Any) -> Any:
        """Rotate the default ladder with the camera; a configured ladder is taken as written."""
        if not isinstance(given, dict) or given.get("rotate") not in (90, 270):
            return given
        ladder = cls.model_fields["renditions"].default
        turned = [
            one.model_copy(update={"width": one.height, "height": one.width}) for one in ladder
        ]
        return {"renditions": turned} | given

    @model_validator(mode="after")
    def _encoder_makes_the_codec(self) -> Self:
        if self.encoder.startswith("h264_") and self.codec != "h264":
            raise ValueError(
                f'encoder {self.encoder} makes H.264; set codec = "h264", or encoder = "auto"'
            )
        return self

    @model_validator(mode="after")
    def _ladder_stands_with_its_camera(self) -> Self:
        width, height = self.upright_size
        for one in self.renditions if self.rotate % 180 else []:
            if (one.width - one.height) * (width - height) < 0:
                raise ValueError(
                    f"rotate = {self.rotate} makes the picture {width}x{height}, and a rendition is"
                    f" {one.size}; swap its width and height"
                )
        return self

    @field_validator("renditions")
    @classmethod
    def _in_order(cls, renditions: list[RenditionSettings]) -> list[RenditionSettings]:
        for above, below in pairwise(renditions):
            if below.bitrate_bps >= above.bitrate_bps:
                raise ValueError(
                    f"{below.name} follows {above.name}; put the one of the higher bit rate first"
                )
        return renditions


class DrivingViewSettings(VideoSettings):
    """`[video]`: the driving view, whose camera looks ahead."""

    source: Annotated[str, Field(min_length=1)] = "auto"
    camera_height_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    camera_tilt_deg: Annotated[float, Field(ge=-30, le=80)] = 0.0
    camera_fov_deg: Annotated[float, Field(ge=0, le=170)] = 0.0

    @model_validator(mode="after")
    def _camera_is_known_or_not(self) -> Self:
        if bool(self.camera_height_m) != bool(self.camera_fov_deg):
            missing = "camera_fov_deg" if self.camera_height_m else "camera_height_m"
            raise ValueError(
                f"camera_height_m and camera_fov_deg belong together; {missing} is missing"
            )
        if 0 < self.camera_fov_deg < MIN_FOV_DEG:
            raise ValueError(
                f"camera_fov_deg is {self.camera_fov_deg:g}; no camera sees less than"
                f" {MIN_FOV_DEG:g} degrees across, or 0 if it is not known"
            )
        if 0 < self.camera_height_m < MIN_CAMERA_HEIGHT_M:
            raise ValueError(
                f"camera_height_m is {self.camera_height_m:g}; a camera that sees the floor is at"
                f" least {MIN_CAMERA_HEIGHT_M:g} m above it, or 0 if its height is not known"
            )
        return self


AxisName = Annotated[
    str,
    Field(
        pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,15}$",
        description="a name of at most 16 letters, digits and _, not beginning with a digit",
    ),
]


MAX_CAMERAS: Final = 4
"""The maximum of cameras beside `[video]`: each is a media section in every page's connection."""


class CameraSettings(VideoSettings):
    """`[[camera]]`: a camera beside the driving view, with a ladder of its own.

    Small pictures use the lowest rendition.
    """

    name: Annotated[
        str,
        Field(
            pattern=r"^[^\x00-\x1f\x7f]{1,24}$",
            description="a text of 1 to 24 printable characters",
        ),
    ]
    axes: Annotated[list[AxisName], Field(max_length=4)] = []
    fps: Annotated[float, Field(ge=1, le=MAX_CAPTURE_FPS)] = 15.0
    renditions: Annotated[list[RenditionSettings], Field(min_length=1, max_length=8)] = [
        RenditionSettings(width=640, height=480, fps=15.0, bitrate_bps=500_000),
        RenditionSettings(width=320, height=240, fps=15.0, bitrate_bps=200_000),
        RenditionSettings(width=160, height=120, fps=5.0, bitrate_bps=30_000),
    ]

    @field_validator("source")
    @classmethod
    def _is_there(cls, source: str) -> str:
        if source == "none":
            raise ValueError("a further camera has a source; leave its table out instead")
        if source == "auto":
            raise ValueError(
                "only [video] takes what it finds; name this camera, as wax devices does"
            )
        return source


class SoundEncodingSettings(_Section):
    """One encoding of the sound, encoded once for all its listeners."""

    mu_ms: Literal[10, 20, 40, 60, 120]
    bitrate_bps: Annotated[int, Field(ge=6_000, le=256_000)]
    stereo_bitrate_bps: Annotated[int, Field(ge=0, le=512_000)] = 0

    @model_validator(mode="after")
    def _stereo_takes_more(self) -> Self:
        if 0 < self.stereo_bitrate_bps < self.bitrate_bps:
            raise ValueError(
                f"stereo_bitrate_bps of the encoding of {self.mu_ms} ms is below its bitrate_bps;"
                " two channels take more than one, or 0 for none"
            )
        return self


class AudioSettings(_Section):
    """`[audio]`."""

    source: Annotated[str, Field(min_length=1)] = "auto"
    channels: Literal[1, 2] = 2
    encodings: Annotated[list[SoundEncodingSettings], Field(min_length=1, max_length=5)] = [
        SoundEncodingSettings(mu_ms=10, bitrate_bps=32_000, stereo_bitrate_bps=56_000),
        SoundEncodingSettings(mu_ms=20, bitrate_bps=32_000, stereo_bitrate_bps=56_000),
        SoundEncodingSettings(mu_ms=40, bitrate_bps=24_000, stereo_bitrate_bps=40_000),
        SoundEncodingSettings(mu_ms=60, bitrate_bps=12_000),
        SoundEncodingSettings(mu_ms=120, bitrate_bps=8_000),
    ]

    @field_validator("encodings")
    @classmethod
    def _in_order(cls, encodings: list[SoundEncodingSettings]) -> list[SoundEncodingSettings]:
        for above, below in pairwise(encodings):
            rises = below.bitrate_bps > above.bitrate_bps
            rises |= 0 < above.stereo_bitrate_bps < below.stereo_bitrate_bps
            if below.mu_ms <= above.mu_ms or rises:
                raise ValueError(
                    f"the encoding of {below.mu_ms} ms follows that of {above.mu_ms} ms; media"
                    " units must grow and bit rates fall from one to the next"
                )
        return encodings


class VoiceSettings(_Section):
    """`[voice]`: speaking to the people beside the robot."""

    speaker: Annotated[str, Field(min_length=1)] = "none"
    open_microphone: bool = False


_MOST_LEVELS: Final = 16
"""Twice the levels that the configuration has."""

_MediaUnitMs = Literal[10, 20, 40, 60, 120]
_HoldbackMs = Annotated[float, Field(ge=0, le=2000)]
_SkewMs = Annotated[float, Field(ge=0, le=500)]


def _player(value: object) -> object:
    """Accept the built-in player's name of version 0.8 and before."""
    return "built-in" if value == "own" else value


class SyncSettings(_Section):
    """`[sync.operator]` and `[sync.observer]`: which stream waits for which, and for how long."""

    policy: Literal["audio-master", "video-first"] = "audio-master"
    audio_mu_ms: Literal["auto", 10, 20, 40, 60, 120] = "auto"
    least_audio_mu_ms: _MediaUnitMs = 20
    finer_ladder: bool = False
    audio_delay_ms: Literal["auto"] | Annotated[float, Field(ge=20, le=500)] = "auto"
    player: Annotated[Literal["auto", "browser", "built-in"], BeforeValidator(_player)] = "auto"
    max_holdback_ms: _HoldbackMs = 500.0
    max_skew_ms: _SkewMs = 20.0


class OperatorSyncSettings(SyncSettings):
    """`[sync.operator]`: its own defaults, also for a file that sets only some keys."""

    least_audio_mu_ms: _MediaUnitMs = 10
    finer_ladder: bool = True
    max_holdback_ms: _HoldbackMs = 50.0
    max_skew_ms: _SkewMs = 145.0


class RoleSyncSettings(_Section):
    """`[sync]`."""

    policy: Literal["by-role", "thesis"] = "by-role"
    operator: OperatorSyncSettings = OperatorSyncSettings()
    observer: SyncSettings = SyncSettings()


class TurnSettings(_Section):
    """`[turns]`: who drives, and for how long."""

    turn_s: Annotated[float, Field(ge=1, le=86_400)] = 60.0
    grace_s: Annotated[float, Field(ge=0, le=60)] = 8.0
    join: Literal["ask", "auto"] = "ask"
    ready_s: Annotated[float, Field(ge=0, le=120)] = 0.0
    idle_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    cooldown_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    max_share_per_person: Annotated[float, Field(gt=0, le=1)] = 1.0
    max_share_per_address: Annotated[float, Field(gt=0, le=1)] = 1.0
    max_waiting_per_address: Annotated[int, Field(ge=1, le=1000)] = 50
    invited_first: bool = True


class DriveSettings(_Section):
    """`[drive]`: how commands become motion."""

    command_rate_hz: Annotated[float, Field(ge=20, le=50)] = 50.0
    loop_hz: Annotated[float, Field(ge=20, le=100)] = 50.0
    max_age_ms: Annotated[float, Field(ge=50, le=1000)] = 150.0
    max_command_age_ms: Annotated[float, Field(ge=50, le=2000)] = 500.0
    slow_picture_age_ms: Annotated[float, Field(ge=100, le=60_000)] = 400.0
    stop_picture_age_ms: Annotated[float, Field(ge=100, le=60_000)] = 800.0
    max_stop_distance_m: Annotated[float, Field(gt=0, le=10)] = 0.3
    slow_fraction: Annotated[float, Field(gt=0, le=1)] = 0.3
    click_to_move: bool = False

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.max_command_age_ms < self.max_age_ms:
            raise ValueError(
                f"max_command_age_ms is {self.max_command_age_ms:g} and max_age_ms"
                f" {self.max_age_ms:g}; max_command_age_ms must be the larger one"
            )
        if self.stop_picture_age_ms < self.slow_picture_age_ms:
            raise ValueError(
                f"stop_picture_age_ms is {self.stop_picture_age_ms:g} and slow_picture_age_ms"
                f" {self.slow_picture_age_ms:g}; stop_picture_age_ms must be the larger one"
            )
        return self


class StopSettings(_Section):
    """`[stop]`: who may press Stop."""

    by: Literal["everybody", "operator"] = "everybody"
    max_per_minute: Annotated[int, Field(ge=1, le=10_000)] = 6
    max_per_minute_per_address: Annotated[int, Field(ge=1, le=10_000)] = 20
    release_after_s: Annotated[float, Field(ge=0, le=60)] = 3.0


Byte = Annotated[int, Field(ge=0, le=255)]
OptionalByte = Annotated[
    Byte | None,
    BeforeValidator(lambda value: None if value == "none" else value),  # TOML has no null
    Field(description='a whole number from 0 to 255, or "none" to send nothing'),
]


class BytesDialectSettings(_Section):
    """`[robot.serial.bytes]`: the thesis's protocol, with the one byte of each command."""

    forward: Byte = ord("F")
    back: Byte = ord("B")
    left: Byte = ord("L")
    right: Byte = ord("R")
    forward_left: Byte = ord("G")
    forward_right: Byte = ord("I")
    back_left: Byte = ord("H")
    back_right: Byte = ord("J")
    stop: Byte = ord("S")
    fine: OptionalByte = ord("1")
    gross: OptionalByte = ord("2")


class SerialSettings(_Section):
    """`[robot.serial]`."""

    url: Annotated[str, Field(min_length=1)] = "/dev/ttyACM0"
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 115_200
    dialect: Literal["frames", "bytes", "text"] = "frames"
    axes: Annotated[list[AxisName], Field(max_length=4)] = []
    ttl_ms: Annotated[int, Field(ge=20, le=1000)] = 200
    reopen_s: Annotated[float, Field(ge=0.05, le=60)] = 0.5
    ticks_per_m: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    bytes: BytesDialectSettings = BytesDialectSettings()
    text: TextDialectSettings = TextDialectSettings()

    @field_validator("axes")
    @classmethod
    def _axes_differ(cls, axes: list[str]) -> list[str]:
        check_apart("two axes have the name {}; give each its own", axes)
        return axes

    @model_validator(mode="after")
    def _has_its_lines(self) -> Self:
        if self.dialect != "text":
            return self
        if not self.text.drive:
            raise ValueError(
                "text.drive is missing: it is the line by which your sketch or controller drives,"
                r' such as "m {left} {right}\r"'
            )
        if len(self.axes) != len(self.text.axis):
            raise ValueError(
                f"axes has {len(self.axes)} names and text.axis {len(self.text.axis)} lines; each"
                " axis needs its own"
            )
        return self


OwnT = TypeVar("OwnT", bound="DriverSettings")


class RobotSettings(_Section):
    """`[robot]`: our keys, and drivers' own tables (`DriverSettings`)."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, dict[str, Any]] = Field(init=False)

    driver: Annotated[str, Field(min_length=1)] = "simulated"
    max_linear_mps: Annotated[float, Field(gt=0, le=10)] = 0.6
    max_angular_rps: Annotated[float, Field(gt=0, le=20)] = 1.5
    max_linear_acceleration_mps2: Annotated[float, Field(gt=0, le=100)] = 1.5
    max_angular_acceleration_rps2: Annotated[float, Field(gt=0, le=200)] = 6.0
    braking_mps2: Annotated[float, Field(gt=0, le=100)] = 2.0
    soft_braking: bool = False
    silence_ms: Annotated[int, Field(ge=60, le=1000)] = 120
    wheel_base_m: Annotated[float, Field(gt=0, le=5)] = 0.3
    width_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    left_trim: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    right_trim: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    invert_left: bool = False
    invert_right: bool = False
    serial: SerialSettings = SerialSettings()

    def own(self, model: type[OwnT]) -> OwnT:
        """Return a driver's own table, with defaults for missing keys."""
        return model.model_validate(self.own_tables.get(model.TABLE, {}))

    @property
    def own_tables(self) -> dict[str, dict[str, Any]]:
        """The drivers' own tables by name, as written."""
        return self.__pydantic_extra__ or {}


Deflection = Annotated[float, Field(ge=-1, le=1)]


class ActSettings(_Section):
    """One act of `[local] script`: what the simulated person aboard does at `at_s`."""

    at_s: Annotated[float, Field(ge=0, le=3600)]
    for_s: Annotated[float, Field(ge=0.1, le=60)] = 0.5
    linear: Deflection = 0.0
    angular: Deflection = 0.0
    press: Literal["stop", "wait", "go_on", "left", "right", "none"] = "none"


class LocalSettings(_Section):
    """`[local]`: the hand control of a person aboard, who outranks every operator."""

    source: Literal["none", "robot", "serial"] = "none"
    url: Annotated[str, Field(min_length=1)] = "/dev/ttyACM1"
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 115_200
    stick: Literal["drives", "shares"] = "drives"
    pause_s: Annotated[float, Field(ge=0.5, le=60)] = 2.0
    max_fraction: Annotated[float, Field(ge=0.05, le=1)] = 0.5
    dead_zone: Annotated[float, Field(ge=0.02, le=0.5)] = 0.1
    silence_ms: Annotated[int, Field(ge=60, le=1000)] = 150
    script: Annotated[list[ActSettings], Field(max_length=64)] = []
    script_s: Annotated[float, Field(ge=1, le=3600)] = 60.0

    @property
    def is_on(self) -> bool:
        """Whether there is a hand control, and so a person aboard."""
        return self.source != "none"

    @model_validator(mode="after")
    def _is_in_time(self) -> Self:
        late = next((act for act in self.script if act.at_s + act.for_s >= self.script_s), None)
        if late is not None:
            raise ValueError(
                f"the act at {late.at_s:g} s ends after script_s, {self.script_s:g} s; make"
                " script_s longer"
            )
        return self


class Settings(_Section):
    """The whole configuration."""

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
    def _controls_differ(self) -> Self:
        check_names(self.controls, self.gauges)
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
