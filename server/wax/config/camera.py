"""`[[camera]]`: cameras beside the driving view."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field, field_validator

from wax.config.allowed import printable
from wax.config.ladder import BESIDE
from wax.config.table import Name
from wax.config.video import MAX_CAPTURE_FPS, RenditionSettings, VideoSettings, automatic

MAX_CAMERAS: Final = 4
"""The maximum of cameras beside `[video]`: each is a media section in every page's connection."""


class CameraSettings(VideoSettings):
    """Further cameras. [video] stays the driving view: the operator always sees it, and only the
    age of its pictures counts for driving. Each further camera is shown small beside it, and large
    at a tap or by the key C. A link, and [network] upload_bps, carry the driving view first; a
    camera gets what that leaves, and its encoders run only while somebody sees it. Rooms of
    [[publish]] and the policy "thesis" show none of them.
    """

    name: Annotated[str, printable(1, 24)]
    """What people call it."""
    axes: Annotated[list[Name], Field(max_length=4)] = []
    """The robot's axes that turn this camera, and not the driving view's."""
    fps: Annotated[float, Field(ge=1, le=MAX_CAPTURE_FPS)] = 15.0
    """Pictures a second to request."""
    renditions: list[RenditionSettings] = automatic(BESIDE)
    """Its ladder, as in [video]; the last is that of the small picture."""

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
