"""`[audio]`: the sound, and its encodings."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from wax.config.table import ConfigTable


class SoundEncodingSettings(ConfigTable):
    """One encoding of the sound, encoded once for all its listeners."""

    mu_ms: Literal[10, 20, 40, 60, 120]
    """Milliseconds of sound in a packet, the thesis's media unit."""
    bitrate_bps: Annotated[int, Field(ge=6_000, le=256_000)]
    """Bits a second, without headers."""
    stereo_bitrate_bps: Annotated[int, Field(ge=0, le=512_000)] = 0
    """Bits a second for two channels; 0: mono only."""

    @model_validator(mode="after")
    def _stereo_takes_more(self) -> Self:
        if 0 < self.stereo_bitrate_bps < self.bitrate_bps:
            raise ValueError(
                f"stereo_bitrate_bps of the encoding of {self.mu_ms} ms is below its bitrate_bps;"
                " two channels take more than one, or 0 for none"
            )
        return self


class AudioSettings(ConfigTable):
    """The sound that viewers hear."""

    source: Annotated[str, Field(min_length=1)] = "auto"
    """Where the sound comes from: "auto" (the robot's own microphone, if it has one, else the
    system's default, else the first that is found; where there is none at the start there is no
    sound, and the log says so), "robot" (its own and no other), "testcard", "none", "microphone"
    (the system's default), one by number or name ("microphone:2", "microphone:USB",
    "microphone:hw:1,0"; `wax devices` lists them; of two alike by its socket,
    "microphone:/dev/snd/by-path/…"), a media file or a stream address (in sync with the same one
    in [video]), or your own class as "package.module:Class"."""
    channels: Literal[1, 2] = 2
    """How many channels the sound has at most. 2 is stereo, by which one hears where a sound comes
    from; a source with one channel stays mono, and so does one whose two are the same. Where one
    of two fails (silent while the other has sound, or at full scale), both ears get the other
    one, and the log and the status say so. 1 is mono, whatever there is. The test card is mono,
    and so is what [[publish]] sends and the thesis's policy."""
    encodings: Annotated[list[SoundEncodingSettings], Field(min_length=1, max_length=5)] = [
        SoundEncodingSettings(mu_ms=10, bitrate_bps=32_000, stereo_bitrate_bps=56_000),
        SoundEncodingSettings(mu_ms=20, bitrate_bps=32_000, stereo_bitrate_bps=56_000),
        SoundEncodingSettings(mu_ms=40, bitrate_bps=24_000, stereo_bitrate_bps=40_000),
        SoundEncodingSettings(mu_ms=60, bitrate_bps=12_000),
        SoundEncodingSettings(mu_ms=120, bitrate_bps=8_000),
    ]
    """How to encode the sound (Opus, 48 kHz), the shortest packets first. Short packets are heard
    sooner, but each has 60 bytes of headers: 24 kbit/s at 20 ms, 8 kbit/s at 60 ms. Each
    viewer's link decides which one they get, or audio_mu_ms below; packets above 60 ms only go
    where otherwise no picture would fit, as on 28.8 kbit/s.

    32 000 gives clear speech and fair music, 12 000 is still easy to understand, 8 000 just; 40 000
    for two channels keep the direction. Each length of packet is sent in stereo where the link
    carries that, else in mono. From one to the next, packets must get longer and bit rates must not
    rise.
    """

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
