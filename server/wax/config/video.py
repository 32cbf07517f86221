"""`[video]`: the driving view, and what it shares with further cameras."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from wax.config.table import ConfigTable

MIN_FOV_DEG: Final = 10.0
MIN_CAMERA_HEIGHT_M: Final = 0.02
MAX_CAPTURE_FPS: Final = 240.0
"""The maximum of a camera; a rendition has at most 60."""


class RenditionSettings(ConfigTable):
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


class VideoSettings(ConfigTable):
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
