"""The thesis's constants, each a key whose default is the thesis's value."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, ValidationInfo, field_validator

from wax.config.allowed import said
from wax.config.table import ConfigTable


class ThesisSettings(ConfigTable):
    """The parameters of the algorithm in chapter 3.3 of the thesis, for policy = "thesis" in
    [sync].
    """

    model_config = ConfigDict(validate_default=True)

    video_mu_ms: Annotated[int, Field(ge=20, le=500)] = 100
    """Milliseconds that one picture lasts, the video media unit: ten a second (3.3.3.1)."""
    audio_mu_ms: Annotated[
        int,
        Field(ge=100, le=500, multiple_of=20),
        said("100 to 500, a whole multiple of video_mu_ms (thesis 3.3.3) and of 20"),
    ] = 500
    """Milliseconds of sound captured and sent as one piece, the audio media unit. The thesis found
    500 by experiment (5.3): shorter ones break up on a slow link."""
    width: Annotated[int, Field(ge=32, le=3840, multiple_of=2)] = 166
    """Width of the picture in pixels, the one size for all (4.2: 166, chosen for modems)."""
    height: Annotated[int, Field(ge=32, le=2160, multiple_of=2)] = 130
    """Height of the picture in pixels (4.2: 129, to the nearest even)."""
    picture_bytes: Annotated[int, Field(ge=1000, le=40_000)] = 8000
    """Bytes of one picture; each is encoded independently, like the thesis's 75 % JPEGs (3.5,
    4.2)."""
    sample_rate_hz: Literal[8000] = 8000
    """How many times a second the sound is sampled: µ-law, one byte each (3.4.1). The codec PCMU
    has no other."""
    fail_safe_fps: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Fail-safe mode begins when fewer pictures a second than this get through (3.5)."""
    reference_audio_buffer_ms: Annotated[float, Field(ge=0, le=500)] = 50.0
    """Milliseconds of sound that a client may buffer; if it buffers more, the picture is rolled
    back further (5.3.1: Java 1.1 had 50, Java 2 had 256)."""
    max_extra_rollback_ms: Annotated[float, Field(ge=0, le=2000)] = 500.0
    """The most milliseconds of that extra roll-back. Not from the thesis: its one case was 206."""
    recover_ms: Annotated[float, Field(ge=0, le=60_000)] = 1000.0
    """Fail-safe mode ends after this many milliseconds without a reason for it; "one second" in
    3.5."""
    lost_after_ms: Annotated[float, Field(ge=1000, le=60_000)] = 5000.0
    """Milliseconds after which an unacknowledged media unit counts as lost. Not from the thesis:
    its TCP lost none."""

    @field_validator("audio_mu_ms")
    @classmethod
    def _whole_multiple(cls, audio_mu_ms: int, info: ValidationInfo) -> int:
        video_mu_ms = info.data.get("video_mu_ms")
        if video_mu_ms is not None and audio_mu_ms % video_mu_ms:
            raise ValueError(
                f"{audio_mu_ms} is no whole multiple of video_mu_ms, which is {video_mu_ms}"
            )
        return audio_mu_ms
