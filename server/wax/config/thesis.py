"""The thesis's constants, each a key whose default is the thesis's value."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, ValidationInfo, field_validator

from wax.config.table import ConfigTable


class ThesisSettings(ConfigTable):
    """`[thesis]`: the constants of the algorithm of chapter 3.3; section numbers are the thesis's.

    The last three keys are ours: the thesis gives no number, or its TCP stream needed none.
    """

    model_config = ConfigDict(validate_default=True)

    video_mu_ms: Annotated[int, Field(ge=20, le=500)] = 100
    """Video MU length, for the camera's 10 pictures a second (3.3.3.1)."""

    audio_mu_ms: Annotated[
        int,
        Field(
            ge=100,
            le=500,
            multiple_of=20,
            description="100 to 500, a whole multiple of video_mu_ms (thesis 3.3.3) and of 20",
        ),
    ] = 500
    """Audio MU length, chosen by experiment (5.3)."""

    width: Annotated[int, Field(ge=32, le=3840, multiple_of=2)] = 166
    height: Annotated[int, Field(ge=32, le=2160, multiple_of=2)] = 130
    """Picture size; the thesis's 166 × 129 (4.2) to the nearest even."""

    picture_bytes: Annotated[int, Field(ge=1000, le=40_000)] = 8000
    """The encoded size of one picture, each independent like a JPEG at 75 % (3.5, 4.2)."""

    sample_rate_hz: Literal[8000] = 8000
    """µ-law, one byte a sample, one channel (3.4.1); the codec PCMU has no other rate."""

    fail_safe_fps: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Fail-safe mode when fewer pictures a second than this get through (3.5)."""

    reference_audio_buffer_ms: Annotated[float, Field(ge=0, le=500)] = 50.0
    """A client that buffers more sound than this gets its picture rolled back further (5.3.1)."""

    max_extra_rollback_ms: Annotated[float, Field(ge=0, le=2000)] = 500.0
    """The limit of the compensation of 5.3.1; the thesis's one case was 206 ms."""

    recover_ms: Annotated[float, Field(ge=0, le=60_000)] = 1000.0
    """Fail-safe mode ends when its cause has been gone for this long: the second of 3.5."""

    lost_after_ms: Annotated[float, Field(ge=1000, le=60_000)] = 5000.0
    """An MU unacknowledged for this long counts as lost; TCP never lost one."""

    @field_validator("audio_mu_ms")
    @classmethod
    def _whole_multiple(cls, audio_mu_ms: int, info: ValidationInfo) -> int:
        video_mu_ms = info.data.get("video_mu_ms")
        if video_mu_ms is not None and audio_mu_ms % video_mu_ms:
            raise ValueError(
                f"{audio_mu_ms} is no whole multiple of video_mu_ms, which is {video_mu_ms}"
            )
        return audio_mu_ms
