"""`[[camera]]`: cameras beside the driving view."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field, field_validator

from wax.config.table import Name
from wax.config.video import MAX_CAPTURE_FPS, RenditionSettings, VideoSettings

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
    axes: Annotated[list[Name], Field(max_length=4)] = []
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
