"""`[video]`: the driving view, and what it shares with further cameras."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from wax.config.allowed import shown
from wax.config.ladder import DRIVING, RateStep, ladder
from wax.config.table import ConfigTable

if TYPE_CHECKING:
    from collections.abc import Sequence

AUTO: Final = "auto"
"""A key with this value counts as left out: it has what is certain until the source is known, VGA,
and `wax.encode.auto_size` replaces it once it is."""
MIN_FOV_DEG: Final = 10.0
MIN_CAMERA_HEIGHT_M: Final = 0.02
MAX_SHORTER_SIDE: Final = 2160
MAX_CAPTURE_FPS: Final = 240.0
"""The maximum of a camera; a rendition has at most 60."""


class RenditionSettings(ConfigTable):
    """One size of the picture, encoded once for all its viewers."""

    width: Annotated[int, Field(ge=32, le=3840, multiple_of=2)]
    """Its width in pixels."""
    height: Annotated[int, Field(ge=32, le=3840, multiple_of=2)]
    """Its height in pixels; the shorter side has at most 2160."""
    fps: Annotated[float, Field(ge=1, le=60)]
    """Pictures a second."""
    bitrate_bps: Annotated[int, Field(ge=10_000, le=20_000_000)]
    """Bits a second; each step has fewer than the one before."""

    @model_validator(mode="after")
    def _is_within_levels(self) -> Self:
        if min(self.width, self.height) > MAX_SHORTER_SIDE:
            raise ValueError(
                f"{self.size} is more than H.264's levels allow at any rate; the shorter side has"
                f" at most {MAX_SHORTER_SIDE}"
            )
        return self

    @property
    def size(self) -> str:
        """The size, which a viewer can choose."""
        return f"{self.width}x{self.height}"

    @property
    def name(self) -> str:
        """A name that tells it from others of the same size."""
        return f"{self.size} at {self.bitrate_bps / 1000:g} kbit/s"


def _or_auto(allowed: str) -> Any:
    """Return the annotation of a key that is `AUTO` by default, with the words for its values."""
    return Field(json_schema_extra={"default": AUTO, "allowed": f"{allowed} or {shown(AUTO)}"})


def automatic(steps: Sequence[RateStep]) -> Any:
    """Return the field of a ladder that is made for the camera's upright size from these steps."""

    def made(keys: dict[str, Any]) -> list[RenditionSettings]:
        size = upright_size(keys["width"], keys["height"], keys["rotate"])
        return ladder_settings(*size, keys["fps"], steps)

    return Field(default_factory=made, min_length=1, max_length=8, json_schema_extra=_LADDER_WORDS)


_LADDER_WORDS: Final[dict[str, Any]] = {
    "default": AUTO,
    "allowed": f"a list of tables, 1 to 8 of them, or {shown(AUTO)}",
}


def ladder_settings(
    width: int, height: int, fps: float, steps: Sequence[RateStep]
) -> list[RenditionSettings]:
    """Return the automatic ladder for an upright picture of this size."""
    return [RenditionSettings(**one._asdict()) for one in ladder(width, height, fps, steps)]


def upright_size(width: int, height: int, rotate: int) -> tuple[int, int]:
    """Return the size of a picture after rotation by this many degrees."""
    return (height, width) if rotate % 180 else (width, height)


class VideoSettings(ConfigTable):
    """A camera: the keys that `[video]` and `[[camera]]` share."""

    source: Annotated[str, Field(min_length=1)] = "robot"
    """As in [video]; "robot" is a view of the robot from outside, if it has one."""
    width: Annotated[
        int,
        Field(ge=32, le=3840, multiple_of=2),
        _or_auto("an even number from 32 to 3840"),
    ] = 640
    """The width in pixels to request from the source; every rendition is scaled from it. "auto" is
    the source's best up to 1280×720 at 25 pictures a second or more, if a trial at the start
    shows that this machine encodes it in time, and otherwise up to 640×480. Beside renditions of
    your own it is the size of the first. Cameras beside the driving view, and the thesis's
    policy, have at most 640×480 by "auto". The log and `wax doctor` say what was chosen, and
    why."""
    height: Annotated[
        int,
        Field(ge=32, le=2160, multiple_of=2),
        _or_auto("an even number from 32 to 2160"),
    ] = 480
    """The height in pixels to request from the source; set it together with width."""
    fps: Annotated[float, Field(ge=1, le=MAX_CAPTURE_FPS)] = 30.0
    """Pictures a second to request from the source. No rendition gets more; one with fewer takes
    the newest, so that twice its rate here makes pictures up to half a picture's time younger,
    and costs the processor twice the decoding."""
    rotate: Literal[0, 90, 180, 270] = 0
    """Degrees by which the picture is turned clockwise, right after it was captured, so that all
    else has it upright: the time on it, the path on the floor, recordings. For a camera that
    hangs upside down (180) or lies on its side (90 or 270; width and height remain the camera's
    own, and the picture and an automatic ladder stand upright). A rotation that a file or a JPEG
    declares is applied before. The test card is never turned, since nobody could read it."""
    mirror: bool = False
    """Swap left and right, after turning: for a camera that looks into a mirror."""
    controls: Annotated[dict[str, bool | int | float], Field(max_length=32)] = {}
    """What the camera is set to when it is opened, such as its exposure and focus: names and values
    as `wax devices` lists them for V4L2's, or those of libcamera for a picamera. A fixed
    exposure of less than a picture's time keeps a webcam from halving its rate in the dark.

    Example: controls = { auto_exposure = 1, exposure_time_absolute = 100, focus_absolute = 30 }
    """
    rtsp_transport: Literal["auto", "tcp", "udp"] = "auto"
    """How a camera at an rtsp:// address sends: "auto" is by TCP, or by UDP where it has no TCP. By
    "udp" a picture may be some milliseconds younger, and is broken where a packet is lost.
    Either way only the newest picture is shown, and a camera that has gone is tried again after
    1, 2, 4 … up to 15 s, after 30 s where it refuses the password, since many lock out those who
    try often."""
    codec: Literal["vp8", "h264"] = "vp8"
    """The video codec, the same for everybody. VP8 has temporal layers, so that a viewer on a slow
    link gets fewer pictures without another encoder; H.264 (constrained baseline) is cheaper to
    decode on some devices, and hardware can encode it."""
    encoder: Literal["auto", "software", "h264_nvenc", "h264_qsv", "h264_amf", "h264_v4l2m2m"] = (
        "auto"
    )
    """What encodes H.264; VP8 is always encoded by the processor. "auto" tries the hardware
    encoders that PyAV knows when the server starts, and takes the first that returns each picture
    at once, in a form that browsers decode; if there is none, or it fails later, the processor
    encodes. `wax devices` shows the trials, and the log says which encoder was taken. "software"
    tries none; a name tries that one only (a Raspberry Pi up to the 4 has h264_v4l2m2m, NVIDIA's
    cards have h264_nvenc, Intel's chips h264_qsv, AMD's h264_amf)."""
    keyframe_interval_s: Annotated[float, Field(ge=0.5, le=60)] = 10.0
    """Seconds between keyframes that nobody requested. Joining viewers and losses request their
    own, so this is only a safety net; each keyframe costs as much as many ordinary frames."""
    timestamp_overlay: bool = False
    """Draw the time of capture (UTC) on the picture: two screens side by side then show by how
    much one is behind."""
    renditions: list[RenditionSettings] = automatic(DRIVING)
    """The rendition ladder, the best step first. Each viewer gets the highest step that their link
    carries, no larger than their window shows or they chose; between two steps, pictures are
    dropped for that viewer alone. Each step costs the machine one encoder while anybody watches
    it.

    "auto" is a ladder of the picture's own shape down to what a telephone modem carries, at most
    30 pictures a second. If the size is "auto", too, rooms of publish get no step above 1 Mbit/s.
    With 1280×720:

    renditions = [
        { width = 1280, height = 720, fps = 30.0, bitrate_bps = 2_500_000 },
        { width = 960, height = 540, fps = 30.0, bitrate_bps = 1_000_000 },
        { width = 640, height = 360, fps = 30.0, bitrate_bps = 600_000 },
        { width = 320, height = 180, fps = 30.0, bitrate_bps = 300_000 },
        { width = 320, height = 180, fps = 15.0, bitrate_bps = 120_000 },
        { width = 160, height = 90, fps = 15.0, bitrate_bps = 50_000 },
        { width = 160, height = 90, fps = 10.0, bitrate_bps = 16_000 },
    ]
    """

    @property
    def is_turned(self) -> bool:
        """Whether the picture is rotated or mirrored."""
        return self.rotate != 0 or self.mirror

    @property
    def upright_size(self) -> tuple[int, int]:
        """Width and height of a picture after rotation."""
        return upright_size(self.width, self.height, self.rotate)

    @property
    def has_auto_size(self) -> bool:
        """Whether `width` and `height` are left to the source and the machine."""
        return "width" not in self.model_fields_set

    @property
    def has_auto_ladder(self) -> bool:
        """Whether `renditions` follow from the size."""
        return "renditions" not in self.model_fields_set

    @model_validator(mode="before")
    @classmethod
    def _auto_is_left_out(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        keys = ("width", "height", "renditions")
        return {key: one for key, one in given.items() if key not in keys or one != AUTO}

    @model_validator(mode="after")
    def _has_a_whole_size(self) -> Self:
        given = self.model_fields_set & {"width", "height"}
        if len(given) == 1:
            raise ValueError(
                f"width and height belong together; {'height' if 'width' in given else 'width'} is"
                " missing"
            )
        return self

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
    """The driving view, whose camera looks ahead."""

    source: Annotated[str, Field(min_length=1)] = "auto"
    """Where the picture comes from: "auto" (the robot's own camera, if it has one, else the first
    that is found, which the log names; while there is none the page says so, and nobody drives),
    "robot" (its own and no other), "testcard", "none", a camera by number or path ("camera:0",
    "camera:/dev/video0"; `wax devices` lists them, and "camera:/dev/v4l/by-id/…" always names
    the same one), "picamera" or "picamera:1" (a camera module of a Raspberry Pi, by Debian's
    package python3-picamera2), a media file or a stream address ("talk.mp4", "rtsp://…"), or
    your own class as "package.module:Class". Nobody drives by a source that does not know how
    old its pictures are: HLS, DASH, a film or a single JPEG by HTTP. A file of this machine is
    played as if it were live."""
    camera_height_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    """Metres from the floor to the camera's lens. With the two keys below the page draws on the
    picture where the robot will be when a command arrives, and where it would then stand. The
    host's panel finds them by two points on the floor (Calibrate). 0 is not known: nothing is
    drawn, except with the simulated robot's own camera, which knows itself."""
    camera_tilt_deg: Annotated[float, Field(ge=-30, le=80)] = 0.0
    """How far it looks down, in degrees; 0 is straight ahead."""
    camera_fov_deg: Annotated[float, Field(ge=0, le=170)] = 0.0
    """How much it sees from left to right, in degrees; 60 to 80 with most webcams. The model is a
    lens that keeps straight lines straight: with a fisheye the drawing is right near the middle
    only. In a headset the picture is curved to fill just that."""
    camera_stereo: bool = False
    """Whether the picture is a stereo pair side by side, the left eye's on the left. A headset
    shows each eye its own half, other screens show both; camera_fov_deg is of one half, and no
    path is drawn."""

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
