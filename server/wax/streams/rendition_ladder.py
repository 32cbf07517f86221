"""`[video] renditions` and `[audio] encodings` as steps to choose from; a finer ladder. Pure."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import sqrt
from typing import TYPE_CHECKING, Final, Literal

from wax.congestion.allocation import SoundEncoding, Step, area
from wax.congestion.sound_choice import FIT_SHARE
from wax.congestion.wire_cost import picture_bps, sound_bps

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from wax.config.settings import (
        AudioSettings,
        RenditionSettings,
        SoundEncodingSettings,
        VideoSettings,
    )

_WIDE: Final = 1.7
"""A viewer with an encoder of their own gets a step between two whose rates differ by more."""
_LAYERS: Final = 2
"""Temporal layers of VP8 that can be left out; H.264 has none here."""


class RenditionLadder:
    """The configuration as the ladder and the hubs want it."""

    def __init__(self, video: VideoSettings, audio: AudioSettings) -> None:
        finer = refined(video.renditions)
        self._settings = {one.name: one for one in finer}
        self._shared = [step_of(one, video.codec) for one in video.renditions]
        self._finer = [step_of(one, video.codec) for one in finer]
        found = (sound_encodings(one, audio.channels) for one in audio.encodings)
        self._encodings = [one for encodings in found for one in encodings]

    def most_bps(self, size: str | None) -> float:
        """Return the rate of a link on which pictures of at most `size` could not be better.

        It is more than they take, since a part of it is kept free. None is for sound alone.
        """
        fitting = (one for one in self._shared if size is not None and area(one.size) <= area(size))
        picture = max((picture_bps(one, 0, one.bitrate_bps) for one in fitting), default=0.0)
        return (picture + sound_bps(self._encodings[0], 0)) / FIT_SHARE

    @property
    def least_bps(self) -> float:
        """The rate on the wire of the smallest picture with the sound that goes with it."""
        step, encoding = self._shared[-1], self._encodings[-1]
        return picture_bps(step, 0, step.bitrate_bps) + sound_bps(encoding, 0)

    def steps(self, *, is_finer: bool) -> Sequence[Step]:
        """Return the shared renditions, or the finer ladder of a viewer with their own encoder.

        A running VP8 encoder does not change its rate, so their own follows the link in steps.
        """
        return self._finer if is_finer else self._shared

    def settings(self, name: str) -> RenditionSettings:
        """Return what a step's rendition is made of."""
        return self._settings[name]

    def encodings(self, least_mu_ms: int) -> Sequence[SoundEncoding]:
        """Return the encodings whose media units are no shorter; the longest where all are."""
        found = [one for one in self._encodings if one.mu_ms >= least_mu_ms]
        return found or self._encodings[-1:]

    def encodings_of(self, mu_ms: int) -> Sequence[SoundEncoding]:
        """Return the encodings of this media unit, at the rates of the nearest on offer."""
        nearest_ms = min((one.mu_ms for one in self._encodings), key=lambda ms: abs(ms - mu_ms))
        return [replace(one, mu_ms=mu_ms) for one in self._encodings if one.mu_ms == nearest_ms]


def sound_encodings(settings: SoundEncodingSettings, channels: int) -> list[SoundEncoding]:
    """Return one of `[audio] encodings`: in stereo, where that is configured, and in mono."""
    mono = SoundEncoding(settings.mu_ms, settings.bitrate_bps)
    if channels == 1 or not settings.stereo_bitrate_bps:
        return [mono]
    return [SoundEncoding(settings.mu_ms, settings.stereo_bitrate_bps, channels), mono]


def refined(renditions: Iterable[RenditionSettings]) -> list[RenditionSettings]:
    """Put between two renditions far apart one of the larger size at the rate in the middle."""
    ladder = list(renditions)
    found = ladder[:1]
    for above, below in pairwise(ladder):
        if above.bitrate_bps > _WIDE * below.bitrate_bps:
            middle_bps = round(sqrt(above.bitrate_bps * below.bitrate_bps) / 1000) * 1000
            found.append(above.model_copy(update={"bitrate_bps": middle_bps}))
        found.append(below)
    return found


def step_of(one: RenditionSettings, codec: Literal["vp8", "h264"]) -> Step:
    """Return a rendition as the step that the allocator knows."""
    layers = _LAYERS if codec == "vp8" else 0
    return Step(
        name=one.name, size=one.size, fps=one.fps, bitrate_bps=one.bitrate_bps, layers=layers
    )
