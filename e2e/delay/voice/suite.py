"""The suite: a voice at the robot, what silences it and what it does to commands; two ears."""

from __future__ import annotations

from functools import partial
from typing import Final

from e2e.delay.voice.command_age import SECONDS, command_age
from e2e.delay.voice.direction import LEAST_OFF_DEG, LISTENS_S, direction
from e2e.delay.voice.mouth_to_speaker import mouth_to_speaker
from e2e.delay.voice.silenced import muted, turn_ended
from e2e.measure.suite import PAGE, SERVER, Suite, measured

_WORDS: Final = "half seconds of speech"
_PAIRS: Final = f"pairs of {SECONDS:g} s, speaking and silent"

SUITE: Final = Suite(
    name="voice",
    about="Measure the voice to the robot, what it does to the commands, and the robot's ears.",
    measures=(*SERVER, *PAGE),
    columns=("median", "p95", "p99", "max"),
    cases=(
        measured(
            "mouth-to-speaker/same-machine",
            300,
            partial(mouth_to_speaker, "same-machine", 100.0),
            _WORDS,
            10,
        ),
        measured(
            "mouth-to-speaker/internet-5m",
            300,
            partial(mouth_to_speaker, "internet-5m", 200.0),
            _WORDS,
            10,
        ),
        measured("mute", 100, partial(muted, 300.0), "times while somebody speaks", 10),
        measured("turn-end", 50, partial(turn_ended, 300.0), "times while somebody speaks", 5),
        measured("direction", 100, direction, f"places, {LISTENS_S:g} s of the radio in each", 20),
        measured(
            "command-age/same-machine", 10, partial(command_age, "same-machine", 2.0), _PAIRS, 1
        ),
        measured("command-age/modem-56k", 10, partial(command_age, "modem-56k", 40.0), _PAIRS, 1),
    ),
    notes=(
        "Mouth to speaker: from when Chromium’s microphone, which is fed from a file, has begun to "
        "hear a piece of speech, its 10 ms of buffer included, to when a sound device (PulseAudio’s"
        " null sink) at the robot plays it; found by correlation of their loudness, ms by ms.",
        "Silence: from when the button is pressed on the host’s page to the end of the last 10 ms"
        " that sound at that device, while its microphone hears speech without pauses; and to when"
        " the operator’s page has the sentence.",
        "Age of the commands: from the page’s call of `send` to the server, by the pings that share"
        " the channel with them; each column is the difference of the two quantiles. A key is held "
        "all the time.",
        "Direction: of the radio in the simulated flat, from places all over it where it is as "
        f"loud as the room’s noise and at least {LEAST_OFF_DEG:g}° off the median plane, by what "
        "differs between the ears alone, from what an Opus decoder gives; front and back are one.",
    ),
)
