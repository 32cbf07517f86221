"""The fan-out of the sound: encoded once a length, only while wanted, the past for who joins."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import numpy as np
import pytest

from wax.config import AudioSettings
from wax.media.sound_encoder import SoundEncoder
from wax.media.sound_hub import SoundHub
from wax.media.source import Sound

if TYPE_CHECKING:
    from wax.media.encoded import EncodedSound


def _speak(hub: SoundHub, first: int, count: int) -> None:
    samples = np.zeros(960, np.int16)
    for number in range(first, first + count):
        hub.push(Sound(samples, 10 + number / 50))


async def _heard(hub: SoundHub, mu_ms: int, preroll_ms: float) -> list[int]:
    """Return the media time, in 20 ms blocks, of what a fresh lane begins with."""
    lane = hub.add()
    hub.choose(lane, mu_ms, preroll_ms)
    got = []
    while lane._queue:
        got.append((await lane.get()).pts // 960 - 500)
    return got


@pytest.mark.parametrize("others", [0, 1])
@pytest.mark.parametrize("preroll_ms", [0, 100, 500])
async def test_who_joins_hears_the_past_at_once(others: int, preroll_ms: float) -> None:
    """The pre-roll is exactly as long as asked, whether or not somebody listened before."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    for _ in range(others):
        hub.choose(hub.add(), 20, 0)
    _speak(hub, 0, 60)
    await asyncio.sleep(0)
    assert await _heard(hub, 20, preroll_ms) == list(range(60 - int(preroll_ms / 20), 60))


async def test_a_second_joiner_hears_of_the_past_what_is_encoded() -> None:
    """Nothing is encoded twice for whoever comes right after the first and asks for more."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 60)
    assert await _heard(hub, 20, 40) == [58, 59]
    _speak(hub, 60, 1)
    assert await _heard(hub, 20, 100) == [58, 59, 60]


@pytest.mark.parametrize(
    ("mu_ms", "preroll_ms", "blocks"),
    [
        (20, 0, 0),
        (20, 1, 1),
        (20, 100, 5),
        (20, 500, 25),
        (40, 100, 6),
        (60, 100, 6),
        (60, 500, 27),
    ],
)
async def test_the_first_listener_costs_no_more_than_his_preroll(
    monkeypatch: pytest.MonkeyPatch, mu_ms: int, preroll_ms: float, blocks: int
) -> None:
    """Of the past as many blocks are encoded as the pre-roll has, in whole media units to now."""
    taken = []

    class Counting(SoundEncoder):
        def encode(self, block: Sound) -> EncodedSound | None:
            taken.append(round(block.captured_s * 50) - 500)
            return super().encode(block)

    monkeypatch.setattr("wax.media.sound_hub.SoundEncoder", Counting)
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 61)
    heard = await _heard(hub, mu_ms, preroll_ms)
    assert taken == list(range(61 - blocks, 61))
    assert heard == taken[:: mu_ms // 20]


async def test_a_preroll_is_not_longer_than_what_was_captured() -> None:
    """Right after the start the past is what there is of it, in whole media units."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 4)
    assert await _heard(hub, 60, 500.0) == [1]
    assert await _heard(hub, 20, 500.0) == [0, 1, 2, 3]


async def test_sound_goes_on_where_the_past_ended() -> None:
    """After the pre-roll every packet follows once and in order."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 30)
    lane = hub.add()
    hub.choose(lane, 20, 60.0)
    _speak(hub, 30, 5)
    await asyncio.sleep(0.01)
    got = [(await lane.get()).pts // 960 - 500 for _ in range(8)]
    assert got == list(range(27, 35))


async def test_media_units_are_encoded_while_wanted() -> None:
    """Each length has its encoder while somebody hears it, and no longer."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    a, b = hub.add(), hub.add()
    hub.choose(a, 20, 0)
    hub.choose(b, 60, 0)
    assert hub.wanted == [20, 60]
    _speak(hub, 0, 6)
    assert hub.counts() == {"captured": 6, "encoded": 8}
    hub.choose(b, None, 0)
    hub.remove(a)
    assert hub.wanted == []
    _speak(hub, 6, 6)
    assert hub.counts()["encoded"] == 8


async def test_what_was_dropped_of_the_sound_stays_counted() -> None:
    """When a viewer who takes no sound leaves, what his lane dropped is still in the sum."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    lane = hub.add()
    hub.choose(lane, 20, 0)
    _speak(hub, 0, 60)
    await asyncio.sleep(0)
    assert hub.dropped == lane.dropped == 10
    hub.remove(lane)
    hub.remove(lane)
    assert hub.dropped == 10
