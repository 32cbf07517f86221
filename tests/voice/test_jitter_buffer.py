"""The jitter buffer: in order, once, with the delay that the link needs, bounded."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.voice.jitter_buffer import JitterBuffer, Missing
from wax.voice.packet import RATE_HZ, VoicePacket

UNIT = 960
UNIT_S = UNIT / RATE_HZ
BEAT_S = 0.005


@dataclass
class Played:
    """The result: packets with their playout times, and how much was concealed."""

    packets: list[tuple[VoicePacket, float]]
    missing: list[tuple[int, float]]

    @property
    def order(self) -> list[int]:
        return [packet.timestamp for packet, _ in self.packets]


def packet(number: int, *, source: int = 1, unit: int = UNIT, first: int = 0) -> VoicePacket:
    return VoicePacket(source, (first + number * unit) % 2**32, unit, b"x")


def play(arrivals: list[tuple[float, VoicePacket]], buffer: JitterBuffer | None = None) -> Played:
    """Push packets at their arrival times and poll every 5 ms until a second after the last."""
    buffer = buffer or JitterBuffer()
    played = Played([], [])
    waiting = sorted(arrivals, key=lambda one: one[0])
    now_s = waiting[0][0]
    end_s = waiting[-1][0] + 1
    while now_s < end_s:
        while waiting and waiting[0][0] <= now_s:
            came_s, one = waiting.pop(0)
            buffer.push(one, came_s)
        while (item := buffer.pop_due(now_s)) is not None:
            if isinstance(item, Missing):
                played.missing.append((item.samples, now_s))
            else:
                played.packets.append((item, now_s))
        now_s += BEAT_S
    return played


def steady(count: int, delay_s: float = 0.05, **more: int) -> list[tuple[float, VoicePacket]]:
    return [(100 + delay_s + n * UNIT_S, packet(n, **more)) for n in range(count)]


def test_a_steady_link_costs_next_to_nothing() -> None:
    """All packets play in order within 35 ms of arrival, with nothing concealed before the end."""
    played = play(steady(100))
    assert played.order == [n * UNIT for n in range(100)]
    waits = [at_s - (100.05 + n * UNIT_S) for n, (_, at_s) in enumerate(played.packets)]
    assert max(waits) < 0.035
    assert all(at_s > 100.05 + 100 * UNIT_S for _, at_s in played.missing)


def test_after_the_last_word_it_fades_and_is_silent() -> None:
    """After the last packet 60 ms are concealed, in case the rest is late; then nothing."""
    played = play(steady(20))
    assert sum(samples for samples, _ in played.missing) == RATE_HZ * 60 // 1000


def test_one_lost_packet_is_made_up_once() -> None:
    """One lost packet's length is concealed, and the next packet plays on time."""
    arrivals = steady(50)
    del arrivals[20]
    played = play(arrivals)
    assert len(played.packets) == 49
    before_end = [samples for samples, at_s in played.missing if at_s < 100.05 + 50 * UNIT_S]
    assert sum(before_end) == UNIT


def test_reordered_packets_are_played_in_order() -> None:
    """On a link that reorders packets, the delay grows until all of them are played."""
    arrivals = [
        (at_s + (0.03 if n % 5 == 4 else 0), one) for n, (at_s, one) in enumerate(steady(200))
    ]
    played = play(arrivals)
    assert played.order == sorted(set(played.order))
    assert len([one for one in played.order if one > 50 * UNIT]) == 149


def test_jitter_is_waited_for_and_no_longer() -> None:
    """After a second of 40 ms jitter hardly anything is missing, and the delay is below 70 ms."""
    arrivals = [(at_s + 0.01 * (n % 5), one) for n, (at_s, one) in enumerate(steady(200))]
    played = play(arrivals)
    late = [at_s - (100.05 + one.timestamp / RATE_HZ) for one, at_s in played.packets[50:]]
    assert max(late) < 0.07
    end_s = 100.05 + 200 * UNIT_S
    assert sum(samples for samples, at_s in played.missing if 101 < at_s < end_s) <= UNIT


def test_a_step_of_the_delay_is_followed() -> None:
    """A link that becomes 150 ms slower costs one gap, and then nothing more is lost."""
    arrivals = [(at_s + (0.15 if n >= 50 else 0), one) for n, (at_s, one) in enumerate(steady(200))]
    played = play(arrivals)
    assert len(played.packets) >= 190
    settled = [samples for samples, at_s in played.missing if 102.2 < at_s < 104.15]
    assert sum(settled) <= UNIT


def test_what_is_late_for_no_reason_is_caught_up() -> None:
    """After a stall of 150 ms the delay is short again within ten seconds of speech."""
    arrivals = [
        (max(at_s, 101.15) if 101.0 <= at_s < 101.15 else at_s, one) for at_s, one in steady(600)
    ]
    played = play(arrivals)
    last = [at_s - (100.05 + one.timestamp / RATE_HZ) for one, at_s in played.packets[-50:]]
    assert max(last) < 0.07


@pytest.mark.parametrize("first", [0, 2**32 - 50 * UNIT, 2**32 - 50 * UNIT - 100])
def test_the_clock_may_wrap(first: int) -> None:
    """Timestamps may wrap around 32 bits in the middle of a word."""
    played = play(steady(100, first=first))
    assert played.order == [(first + n * UNIT) % 2**32 for n in range(100)]


def test_a_pause_of_the_clock_is_no_delay() -> None:
    """A browser whose timestamps resume where they stopped two seconds ago is heard at once."""
    buffer = JitterBuffer()
    play(steady(50), buffer)
    again = [(104 + n * UNIT_S, packet(50 + n)) for n in range(50)]
    played = play(again, buffer)
    assert len(played.packets) == 50
    assert played.packets[0][1] - 104 < 0.03


def test_another_speaker_begins_anew() -> None:
    """Another source starts over, whatever its timestamps are."""
    buffer = JitterBuffer()
    play(steady(50), buffer)
    again = [(101.3 + n * UNIT_S, packet(n, source=2, first=123_456_789)) for n in range(50)]
    assert len(play(again, buffer).packets) == 50


def test_a_silence_in_the_stream_is_not_made_up() -> None:
    """A gap of more than 60 ms, as discontinuous transmission leaves, is not concealed."""
    arrivals = [one for n, one in enumerate(steady(100)) if not 40 <= n < 60]
    played = play(arrivals)
    assert len(played.packets) == 80
    between = [samples for samples, at_s in played.missing if at_s < 100.05 + 100 * UNIT_S]
    assert sum(between) <= RATE_HZ * 60 // 1000


def test_cleared_it_plays_nothing_of_before() -> None:
    """Packets that waited at a clear are never played."""
    buffer = JitterBuffer()
    for came_s, one in steady(3):
        buffer.push(one, came_s)
    buffer.clear()
    assert buffer.is_idle
    assert buffer.pop_due(200.0) is None


EVENT = st.tuples(
    st.floats(0, 0.4),
    st.one_of(st.integers(0, 100).map(lambda n: n * UNIT), st.integers(0, 2**32 - 1)),
    st.sampled_from([120, 480, 960, 2880, 5760]),
    st.integers(1, 2),
)


@examples(400)
@given(st.lists(EVENT, max_size=120))
def test_no_stream_breaks_it(events: list[tuple[float, int, int, int]]) -> None:
    """Whatever arrives: bounded, nothing twice, and never more sound than time that has passed."""
    buffer = JitterBuffer()
    now_s = 100.0
    given_in: list[VoicePacket] = []
    played: list[VoicePacket] = []
    samples = 0
    for pause_s, timestamp, length, source in events:
        now_s += pause_s
        one = VoicePacket(source, timestamp, length, b"x")
        given_in.append(one)
        buffer.push(one, now_s)
        for _ in range(200):
            item = buffer.pop_due(now_s)
            if item is None:
                break
            samples += item.samples
            if isinstance(item, VoicePacket):
                played.append(item)
        assert buffer.pop_due(now_s) is None
        assert len(buffer._packets) <= 64
    assert len({id(one) for one in played}) == len(played)
    assert {id(one) for one in played} <= {id(one) for one in given_in}


@examples(200)
@given(
    st.lists(st.floats(0, 0.1), min_size=30, max_size=150),
    st.lists(st.booleans(), min_size=150, max_size=150),
)
def test_one_stream_is_played_in_order(jitters_s: list[float], lost: list[bool]) -> None:
    """With jitter up to 100 ms and any loss: in order, once, at most 300 ms after speaking."""
    arrivals = [
        (100 + n * UNIT_S + jitter_s, packet(n))
        for n, jitter_s in enumerate(jitters_s)
        if not lost[n]
    ]
    if not arrivals:
        return
    played = play(arrivals)
    assert played.order == sorted(set(played.order))
    for one, at_s in played.packets:
        assert at_s - (100 + one.timestamp / RATE_HZ) < 0.5
