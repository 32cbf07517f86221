"""The voice's suite, short: words are found at the robot's speaker, and commands are compared."""

from __future__ import annotations

import pytest

from e2e.delay.voice.command_age import command_age
from e2e.delay.voice.direction import direction, stereo_forms
from e2e.delay.voice.mouth_to_speaker import MOST_MS, mouth_to_speaker
from e2e.delay.voice.silenced import muted, turn_ended
from e2e.harness.missing import missing
from e2e.measure.errors import NotRunError

pytestmark = pytest.mark.timeout(180)

SECONDS = 5.0


async def test_words_are_found_at_the_robots_speaker() -> None:
    """Each half second of them, later than it was said."""
    try:
        (row,) = await mouth_to_speaker("same-machine", MOST_MS, 8)
    except NotRunError as error:
        missing(str(error))
    assert (row.n, row.met) == (8, True)
    assert row.spread is not None
    assert row.spread.min > 0


async def test_the_radio_is_on_its_side() -> None:
    """In every form of the ladder that has two channels."""
    rows = await direction(5)
    assert len(rows) == 2 * len(stereo_forms()) > 0
    assert all(row.met for row in rows)


async def test_commands_are_compared_while_a_voice_is_played() -> None:
    """Pings came in both stretches, and the robot's speaker sounded in the one."""
    try:
        age, too_old, played = await command_age("same-machine", 1000.0, 1, seconds=SECONDS)
    except NotRunError as error:
        missing(str(error))
    assert age.n >= 10
    assert too_old.n > 50
    assert (played.values["median"] or 0) > 20


async def test_the_host_silences_a_voice() -> None:
    """By muting and by ending the turn it is spoken in; before, it sounded all the time."""
    try:
        rows = await muted(300.0, 3) + await turn_ended(300.0, 2)
    except NotRunError as error:
        missing(str(error))
    assert [(row.n, row.met) for row in rows] == [(3, True), (3, True), (2, True)]
