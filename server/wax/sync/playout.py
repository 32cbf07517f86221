"""A policy's input and output: playout reports and buffer targets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.sentence import Sentence


@dataclass(frozen=True, slots=True)
class StreamPlayout:
    """How one stream plays on a viewer's page; None for what the browser does not report.

    `age_ms` is the delay from capture to screen or ear, `delay_ms` the part of it in the jitter
    buffer and `output_ms` the part in the device. `concealed_ms` and `played_ms` are totals of the
    sound since the peer connection began. `is_built_in` means that the page's built-in player
    plays the sound and chooses its delay.
    """

    age_ms: float | None = None
    delay_ms: float | None = None
    concealed_ms: float | None = None
    played_ms: float | None = None
    output_ms: float | None = None
    is_built_in: bool = False


@dataclass(frozen=True, slots=True)
class PlayoutReport:
    """A viewer's latest report; a stream that is switched off is None."""

    sound: StreamPlayout | None
    picture: StreamPlayout | None


@dataclass(frozen=True, slots=True)
class PlayoutTargets:
    """The minimum delay of each jitter buffer, in ms; None leaves it to the browser.

    `reason` explains them to people. `in_step` is False while delivery comes first: the link cannot
    carry both streams, and each plays as soon as it can.
    """

    sound_ms: float | None
    picture_ms: float | None
    reason: Sentence
    in_step: bool = True
