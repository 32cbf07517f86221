"""The fan-out of the sound: encoded once per encoding, only while wanted, with a pre-roll."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.encode.decoders import decoded_sound
from tests.examples import examples
from tests.open_boundary import OpenFence
from tests.turned_clock import TurnedClock

from wax.capture.source import BLOCK_SAMPLES, Sound
from wax.congestion.allocation import SoundEncoding
from wax.encode.sound_encoder import SoundEncoder
from wax.fanout.sound_hub import SoundHub

if TYPE_CHECKING:
    from wax.encode.encoded import EncodedSound
    from wax.fanout.sound_lane import BoundedSoundLane

FIRST = 1200
"""The first block's number; a whole number of units of every length begins there."""

ENCODINGS = {mu_ms: SoundEncoding(mu_ms, 32_000) for mu_ms in (10, 20, 40, 60, 120)}


class _Hub(SoundHub):
    """A hub whose time is the end of the last block."""

    def __init__(self) -> None:
        self.time = TurnedClock(FIRST / 100)
        super().__init__(self.time)


def _hub() -> _Hub:
    hub = _Hub()
    hub.start()
    return hub


def _speak(hub: _Hub, first: int, count: int) -> None:
    samples = np.zeros(BLOCK_SAMPLES, np.int16)
    for number in range(FIRST + first, FIRST + first + count):
        hub.push(Sound(samples, number / 100))
        hub.time.time_s = (number + 1) / 100


def _drain(lane: BoundedSoundLane) -> list[EncodedSound]:
    found = []
    while (one := lane.pop_next()) is not None:
        found.append(one)
    return found


def _numbers(sounds: list[EncodedSound]) -> list[int]:
    """Return the numbers of all blocks that these packets hold."""
    return [
        one.pts // BLOCK_SAMPLES - FIRST + n
        for one in sounds
        for n in range(one.duration_samples // BLOCK_SAMPLES)
    ]


async def _heard(hub: SoundHub, encoding: SoundEncoding, preroll_ms: float) -> list[int]:
    """Return the numbers of the blocks that a fresh lane begins with."""
    lane = hub.add(OpenFence())
    hub.choose(lane, encoding, preroll_ms)
    return _numbers(_drain(lane))


async def test_as_many_channels_as_are_captured() -> None:
    """The channel count follows the newest block."""
    hub = _hub()
    hub.push(Sound(np.zeros((BLOCK_SAMPLES, 2), np.int16), 12.0))
    assert hub.channels == 2
    _speak(hub, 1, 1)
    assert hub.channels == 1


@pytest.mark.parametrize("others", [0, 1])
@pytest.mark.parametrize("preroll_ms", [0, 100, 500])
async def test_who_joins_hears_the_past_at_once(others: int, preroll_ms: float) -> None:
    """The pre-roll is exactly as long as requested, whether or not somebody listened before."""
    hub = _hub()
    for _ in range(others):
        hub.choose(hub.add(OpenFence()), ENCODINGS[20], 0)
    _speak(hub, 0, 120)
    await asyncio.sleep(0)
    heard = await _heard(hub, ENCODINGS[20], preroll_ms)
    assert heard == list(range(120 - int(preroll_ms / 10), 120))


async def test_a_second_joiner_hears_of_the_past_what_is_encoded() -> None:
    """A second listener who asks for more gets only what is already encoded."""
    hub = _hub()
    _speak(hub, 0, 60)
    assert await _heard(hub, ENCODINGS[20], 40) == [56, 57, 58, 59]
    _speak(hub, 60, 2)
    assert await _heard(hub, ENCODINGS[20], 100) == [56, 57, 58, 59, 60, 61]


@pytest.mark.parametrize("mu_ms", ENCODINGS)
@pytest.mark.parametrize("preroll_ms", [0, 1, 100, 500])
async def test_the_first_listener_costs_no_more_than_their_preroll(
    monkeypatch: pytest.MonkeyPatch, mu_ms: int, preroll_ms: float
) -> None:
    """Of the past as many units are encoded as the pre-roll has, and the one under way."""
    taken = []

    class Counting(SoundEncoder):
        def encode(self, block: Sound, pts: int) -> EncodedSound | None:
            taken.append(pts // BLOCK_SAMPLES - FIRST)
            return super().encode(block, pts)

    monkeypatch.setattr("wax.fanout.sound_hub.SoundEncoder", Counting)
    hub = _hub()
    _speak(hub, 0, 125)
    heard = await _heard(hub, ENCODINGS[mu_ms], preroll_ms)
    unit = mu_ms // 10
    whole = 125 // unit * unit
    assert heard == list(range(whole - int(np.ceil(preroll_ms / mu_ms)) * unit, whole))
    assert taken == [*heard, *range(whole, 125)]


async def test_who_ends_a_rest_hears_silence_and_then_what_is_captured() -> None:
    """Nothing captured before they came is heard, and media time goes on with the clock."""
    hub = _hub()
    lane = hub.add(OpenFence())
    hub.choose(lane, ENCODINGS[20], 0)
    assert hub.needed.is_set()
    _speak(hub, 0, 20)
    hub.remove(lane)
    assert not hub.needed.is_set()
    hub.time.time_s += 60
    hub.skip(Sound(np.zeros((7, 2), np.int16), hub.time.time_s))
    assert (hub.channels, hub.counts()["captured"]) == (2, 21)
    lane = hub.add(OpenFence())
    hub.choose(lane, ENCODINGS[20], 500)
    assert hub.needed.is_set()
    _speak(hub, 6015, 15)
    await asyncio.sleep(0)
    heard = _drain(lane)
    assert _numbers(heard) == list(range(5970, 6030))
    for one in heard:
        assert one.captured_s == pytest.approx(one.pts / 48_000, abs=0.007)


async def test_sound_goes_on_where_the_past_ended() -> None:
    """After the pre-roll every packet follows once and in order."""
    hub = _hub()
    _speak(hub, 0, 31)
    lane = hub.add(OpenFence())
    hub.choose(lane, ENCODINGS[20], 60.0)
    _speak(hub, 31, 5)
    await asyncio.sleep(0.01)
    assert _numbers(_drain(lane)) == list(range(24, 36))


async def test_encodings_are_encoded_while_wanted() -> None:
    """Each encoding has its encoder while somebody hears it, and no longer."""
    hub = _hub()
    a, b = hub.add(OpenFence()), hub.add(OpenFence())
    hub.choose(a, ENCODINGS[20], 0)
    hub.choose(b, ENCODINGS[60], 0)
    assert hub.wanted == [ENCODINGS[20].name, ENCODINGS[60].name]
    _speak(hub, 0, 12)
    assert hub.counts() == {"captured": 12, "encoded": 8}
    hub.choose(b, ENCODINGS[20], 0)
    assert hub.wanted == [ENCODINGS[20].name, ENCODINGS[60].name]
    _speak(hub, 12, 18)
    await asyncio.sleep(0)
    assert hub.wanted == [ENCODINGS[20].name]
    hub.choose(b, None, 0)
    hub.remove(a)
    assert hub.wanted == []
    encoded = hub.counts()["encoded"]
    _speak(hub, 30, 12)
    assert hub.counts()["encoded"] == encoded


async def test_what_was_dropped_of_the_sound_stays_counted() -> None:
    """When a viewer leaves, what their lane dropped still counts."""
    hub = _hub()
    lane = hub.add(OpenFence())
    hub.choose(lane, ENCODINGS[20], 0)
    _speak(hub, 0, 120)
    await asyncio.sleep(0)
    assert hub.dropped == lane.dropped == 10
    hub.remove(lane)
    hub.remove(lane)
    assert hub.dropped == 10


Act = tuple[str, int, int]

_acts = st.lists(
    st.tuples(st.just("choose"), st.integers(0, 2), st.sampled_from(list(ENCODINGS)))
    | st.tuples(st.just("speak"), st.integers(1, 30), st.just(0))
    | st.tuples(st.just("deliver"), st.just(0), st.just(0))
    | st.tuples(st.just("leave"), st.integers(1, 2), st.just(0)),
    max_size=40,
)


@examples(150)
@given(
    phase=st.integers(0, 11),
    begun=st.integers(0, 20),
    first=st.sampled_from(list(ENCODINGS)),
    acts=_acts,
)
def test_every_sample_is_sent_once_whatever_the_changes(
    phase: int, begun: int, first: int, acts: list[Act]
) -> None:
    """However encodings change, also for others, no sample is missed or sent twice."""

    async def listen() -> tuple[list[EncodedSound], int]:
        hub = _hub()
        lanes = [hub.add(OpenFence()) for _ in range(3)]
        now, waiting = phase, 0
        hub.time.time_s = (FIRST + phase) / 100
        _speak(hub, now, begun)
        now += begun
        hub.choose(lanes[0], ENCODINGS[first], 40)
        heard = _drain(lanes[0])
        for act, one, two in acts:
            if act == "choose":
                hub.choose(lanes[one], ENCODINGS[two], 40)
            elif act == "leave":
                hub.choose(lanes[one], None, 0)
            elif act == "speak":
                _speak(hub, now, one)
                now += one
                waiting += one
            if act == "deliver" or waiting > 60:  # a lane holds no more than 100
                await asyncio.sleep(0)
                heard += _drain(lanes[0])
                waiting = 0
        await asyncio.sleep(0)
        return heard + _drain(lanes[0]), now

    heard, now = asyncio.run(listen())
    numbers = _numbers(heard)
    if numbers:
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        assert now - numbers[-1] <= 12
    else:
        assert now < phase + 24
    for one in heard:
        assert one.captured_s == pytest.approx(one.pts / 48_000, abs=0.007)


async def test_a_change_of_encoding_is_not_heard() -> None:
    """While encodings change, a tone goes on: softer for 0.1 s at most, never silent."""
    encodings = [SoundEncoding(20, 32_000), SoundEncoding(60, 12_000), SoundEncoding(40, 24_000)]
    tone = (1600 * np.sin(np.arange(480 * 600) * 2 * np.pi * 300 / 48_000)).astype(np.int16)
    hub = _hub()
    lane = hub.add(OpenFence())
    sounds = []
    for number in range(600):
        if number % 57 == 0:
            hub.choose(lane, encodings[number // 57 % 3], 0)
        hub.push(Sound(tone[number * 480 : number * 480 + 480], (FIRST + number) / 100))
        await asyncio.sleep(0)
        sounds += _drain(lane)
    heard = decoded_sound(sounds)
    assert len(sounds) > 100
    blocks = heard[4800 : len(heard) // 480 * 480].reshape(-1, 480)
    shares = np.sqrt(np.mean(blocks**2, axis=1)) / (1600 / np.sqrt(2))
    assert shares.min() > 0.25
    assert shares.max() < 1.5
    changes = 600 // 57
    assert np.count_nonzero(shares < 0.8) <= 10 * changes


async def test_after_a_real_gap_the_sound_goes_on_in_the_encoding_that_was_chosen() -> None:
    """A microphone that was away in the middle of a change leaves no viewer without sound."""
    hub = _hub()
    lane = hub.add(OpenFence())
    hub.choose(lane, ENCODINGS[20], 0)
    _speak(hub, 0, 3)
    hub.choose(lane, ENCODINGS[60], 0)
    _speak(hub, 1004, 20)
    await asyncio.sleep(0)
    numbers = _numbers(_drain(lane))
    assert numbers[:2] == [0, 1]
    assert numbers[2:] == list(range(1008, 1008 + len(numbers) - 2))
    assert len(numbers) >= 2 + 12
