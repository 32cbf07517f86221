"""The values between a page's measurements and what a policy makes of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StreamPlayout:
    """How one stream plays at a viewer's; None where the browser does not tell.

    `age_ms` is from capture to eye or ear, `delay_ms` the part of it in the jitter buffer and
    `output_ms` that in the device. `concealed_ms` of `played_ms` of the sound, since the peer
    began, were made up.
    """

    age_ms: float | None = None
    delay_ms: float | None = None
    concealed_ms: float | None = None
    played_ms: float | None = None
    output_ms: float | None = None


@dataclass(frozen=True, slots=True)
class PlayoutReport:
    """What a viewer measured last; a stream that is switched off is None."""

    sound: StreamPlayout | None
    picture: StreamPlayout | None


@dataclass(frozen=True, slots=True)
class PlayoutTargets:
    """The least delay that each jitter buffer shall keep, in ms; None leaves it to the browser.

    `reason` says in plain words why. `in_step` False is fail-safe mode: the link cannot carry both,
    and each plays as soon as it can.
    """

    sound_ms: float | None
    picture_ms: float | None
    reason: str
    in_step: bool = True
