"""Turns `[video] renditions` and `[audio] encodings` into ladders of steps. Pure."""

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

    from wax.config.audio import AudioSettings, SoundEncodingSettings
    from wax.config.video import RenditionSettings, VideoSettings

_WIDE: Final = 1.7
"""The finer ladder has a step between two whose rates differ by more than this factor."""
_LAYERS: Final = 2
"""The temporal layers of VP8 that can be dropped; our H.264 has none."""


class RenditionLadder:
    """The configured ladder, in the forms that allocator and hubs use."""

    def __init__(self, video: VideoSettings, audio: AudioSettings) -> None:
        finer = refined(video.renditions)
        self._settings = {one.name: one for one in finer}
        self._shared = [step_of(one, video.codec) for one in video.renditions]
        self._finer = [step_of(one, video.codec) for one in finer]
        self._most_bps = [
            (area(one.size), picture_bps(one, 0, one.bitrate_bps)) for one in self._shared
        ]
        found = (sound_encodings(one, audio.channels) for one in audio.encodings)
        self._encodings = [one for encodings in found for one in encodings]

    def most_bps(self, size: str | None) -> float:
        """Return the link rate above which pictures of at most `size` do not improve.

        It exceeds their own rate, because part of the link stays free. None is sound alone.
        """
        pixels = 0 if size is None else area(size)
        picture = max((bps for own, bps in self._most_bps if own <= pixels), default=0.0)
        return (picture + sound_bps(self._encodings[0], 0)) / FIT_SHARE

    @property
    def least_bps(self) -> float:
        """The rate on the wire of the smallest picture and the cheapest sound."""
        step, encoding = self._shared[-1], self._encodings[-1]
        return picture_bps(step, 0, step.bitrate_bps) + sound_bps(encoding, 0)

    def steps(self, *, is_finer: bool) -> Sequence[Step]:
        """Return the shared renditions, or the finer ladder of a viewer with a separate encoder.

        A running VP8 encoder cannot change its rate, so a separate one also uses steps.
        """
        return self._finer if is_finer else self._shared

    def settings(self, name: str) -> RenditionSettings:
        """Return the settings of a step's rendition."""
        return self._settings[name]

    def encodings(self, least_mu_ms: int) -> Sequence[SoundEncoding]:
        """Return the encodings with media units of at least this length, or else the longest."""
        found = [one for one in self._encodings if one.mu_ms >= least_mu_ms]
        return found or self._encodings[-1:]

    def encodings_of(self, mu_ms: int) -> Sequence[SoundEncoding]:
        """Return encodings with this media unit, at the rates of the nearest configured one."""
        nearest_ms = min((one.mu_ms for one in self._encodings), key=lambda ms: abs(ms - mu_ms))
        return [replace(one, mu_ms=mu_ms) for one in self._encodings if one.mu_ms == nearest_ms]


def sound_encodings(settings: SoundEncodingSettings, channels: int) -> list[SoundEncoding]:
    """Return a configured encoding in stereo, if configured, and in mono."""
    mono = SoundEncoding(settings.mu_ms, settings.bitrate_bps)
    if channels == 1 or not settings.stereo_bitrate_bps:
        return [mono]
    return [SoundEncoding(settings.mu_ms, settings.stereo_bitrate_bps, channels), mono]


def refined(renditions: Iterable[RenditionSettings]) -> list[RenditionSettings]:
    """Insert between distant renditions one of the larger size at their geometric mean rate."""
    ladder = list(renditions)
    found = ladder[:1]
    for above, below in pairwise(ladder):
        if above.bitrate_bps > _WIDE * below.bitrate_bps:
            middle_bps = round(sqrt(above.bitrate_bps * below.bitrate_bps) / 1000) * 1000
            found.append(above.model_copy(update={"bitrate_bps": middle_bps}))
        found.append(below)
    return found


def step_of(one: RenditionSettings, codec: Literal["vp8", "h264"]) -> Step:
    """Return a rendition as a step for the allocator."""
    layers = _LAYERS if codec == "vp8" else 0
    return Step(
        name=one.name, size=one.size, fps=one.fps, bitrate_bps=one.bitrate_bps, layers=layers
    )
