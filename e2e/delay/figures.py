"""What a cell is judged by: the figures made of its readings, None where there is nothing to."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from e2e.measure.summary import Summary


class _Figures(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Pauses(_Figures):
    """Interruptions of the sound, in the order in which they came."""

    at_ms: list[float] = []
    """Unix time of the begin of each."""
    length_ms: list[float] = []


class Figures(_Figures):
    """One cell, measured from `from_ms` to `to_ms` (Unix); the first 3 s are not counted."""

    from_ms: float
    to_ms: float
    sound_from_ms: float
    """What is heard counts from here to `to_ms`: later than `from_ms` where the sound came late,
    and beyond `to_ms` where it came too late to be judged."""
    picture_age_ms: Summary | None = None
    """Capture to presentation of each presented frame."""
    sound_age_ms: Summary | None = None
    """Capture to ear of each second's burst."""
    skew_ms: Summary | None = None
    """Sound's age less picture's: above 0 the sound comes after the picture."""
    absolute_skew_p95_ms: float | None = None
    pictures_per_s: float | None = None
    longest_freeze_ms: float | None = None
    """The longest time for which one picture stood, to the end of the cell where it stands."""
    tone_pauses: Pauses = Pauses()
    """Gaps of 30 ms or more in the tone."""
    concealed_pauses: Pauses = Pauses()
    """Contiguous concealment of 100 ms or more, by the browser's counts."""
    concealed_share: float | None = None
    stretched_share: float | None = None
    first_picture_ms: float | None = None
    """From the begin of the navigation."""
    command_round_trip_ms: Summary | None = None
    received_bytes_per_s: float | None = None
    """All that the transport carried to the page, of which `audio…` and `video…` are RTP."""
    received_audio_bytes_per_s: float | None = None
    received_video_bytes_per_s: float | None = None
    sent_bytes_per_s: float | None = None
    picture_drift_ms_per_min: float | None = None
    sound_drift_ms_per_min: float | None = None
    lip_lag_ms: float | None = None
    """By how much a talking head's voice comes after its lips, where their correlation peaks."""
    lip_correlation: float | None = None
    speech_quality: float | None = None
    """ViSQOL's mean opinion score of what was heard of the voice, 1 to 5: the median sentence."""
