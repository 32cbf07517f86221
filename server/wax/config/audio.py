"""`[audio]`: the sound, and its encodings."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from wax.config.table import ConfigTable


class SoundEncodingSettings(ConfigTable):
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


class AudioSettings(ConfigTable):
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
