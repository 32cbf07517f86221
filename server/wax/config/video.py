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
    """Its width in pixels."""
    height: Annotated[int, Field(ge=32, le=2160, multiple_of=2)]
    """Its height in pixels."""
    fps: Annotated[float, Field(ge=1, le=60)]
    """Pictures a second."""
    bitrate_bps: Annotated[int, Field(ge=10_000, le=20_000_000)]
    """Bits a second, less at each step."""

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
    """As in [video]; "robot" is a view of the robot from outside, if it has one."""
    width: Annotated[int, Field(ge=32, le=3840, multiple_of=2)] = 640
    """The width in pixels to request from the source; every rendition is scaled from it."""
    height: Annotated[int, Field(ge=32, le=2160, multiple_of=2)] = 480
    """The height in pixels to request from the source."""
    fps: Annotated[float, Field(ge=1, le=MAX_CAPTURE_FPS)] = 30.0
    """Pictures a second to request from the source. Renditions cannot have more; with fewer they
    take the newest, so that a sensor at twice their rate saves up to half a picture's time, and
    costs the processor twice the decoding."""
    rotate: Literal[0, 90, 180, 270] = 0
    """Degrees by which the picture is turned clockwise, right after it was captured, so that all
    else has it upright: the time on it, the path on the floor, recordings. For a camera that
    hangs upside down (180) or lies on its side (90 or 270; width and height are then swapped,
    and so is the ladder below, unless you write your own). What a file or a JPEG says of itself
    is honoured before. The test card stays as it is, for else nobody could read it."""
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
    decode on some devices."""
    encoder: Literal["auto", "software", "h264_nvenc", "h264_qsv", "h264_amf", "h264_v4l2m2m"] = (
        "auto"
    )
    """What encodes H.264; VP8 is always encoded by the processor. "auto" tries the hardware
    encoders that PyAV knows when the server starts, and takes one that gives each picture out at
    once, in the same profile, as browsers can decode it, else the processor; `wax devices` shows
    the trials, the log and the status what was taken. What fails later is encoded by the
    processor from the next picture on. "software" tries nothing; a name tries that one only (a
    Raspberry Pi up to the 4 has h264_v4l2m2m, NVIDIA's cards have h264_nvenc, Intel's chips
    h264_qsv, AMD's h264_amf)."""
    keyframe_interval_s: Annotated[float, Field(ge=0.5, le=60)] = 10.0
    """Seconds between keyframes that nobody requested. Joining viewers and losses request their
    own, so this is only a safety net; each keyframe costs as much as many ordinary frames."""
    timestamp_overlay: bool = False
    """Draw the wall clock (UTC) on the picture. The thesis judged drift by it."""
    renditions: Annotated[list[RenditionSettings], Field(min_length=1, max_length=8)] = [
        RenditionSettings(width=640, height=480, fps=30.0, bitrate_bps=1_000_000),
        RenditionSettings(width=640, height=480, fps=30.0, bitrate_bps=600_000),
        RenditionSettings(width=320, height=240, fps=30.0, bitrate_bps=300_000),
        RenditionSettings(width=320, height=240, fps=15.0, bitrate_bps=120_000),
        RenditionSettings(width=160, height=120, fps=15.0, bitrate_bps=50_000),
        RenditionSettings(width=160, height=120, fps=10.0, bitrate_bps=16_000),
    ]
    """The rendition ladder, the best step first. Each viewer gets the highest step that their link
    carries, no larger than the size they chose; between two steps, pictures are dropped for that
    viewer alone. Each step costs the machine one encoder while anybody watches it.

    The lowest default step still lets you drive over a telephone modem.
    """

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
    only."""

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
