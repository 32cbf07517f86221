"""The sound's lane: it sends each sample once, is bounded, and repeats packets on request."""

from __future__ import annotations

from functools import partial

from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.allocation import SoundEncoding
from wax.encode.encoded import EncodedSound
from wax.fanout.sound_lane import BoundedSoundLane

SHORT = SoundEncoding(20, 32_000)
LONG = SoundEncoding(60, 12_000)


def _sound(number: int, encoding: SoundEncoding = SHORT) -> EncodedSound:
    """Make the packet that begins `number` times 20 ms after the start."""
    return EncodedSound(b"x", number * 960, number / 50, encoding.mu_ms * 48)


def _earlier(lane: BoundedSoundLane, sound: EncodedSound, count: int) -> tuple[EncodedSound, ...]:
    lane.redundancy = count
    return lane.packets_to_repeat(sound)


def _take(lane: BoundedSoundLane, count: int) -> list[EncodedSound]:
    return [one for _ in range(count) if (one := lane.pop_next()) is not None]


def _numbers(sounds: list[EncodedSound] | tuple[EncodedSound, ...]) -> list[int]:
    return [one.pts // 960 for one in sounds]


def test_sound_that_overlaps_is_sent_once() -> None:
    """A packet in both the pre-roll and the stream is sent once."""
    lane = BoundedSoundLane()
    lane.choose(SHORT)
    for number in (1, 2, 3, 3, 2, 4):
        lane.put(SHORT, _sound(number))
    assert _numbers(_take(lane, 4)) == [1, 2, 3, 4]


def test_the_new_encoding_follows_where_the_old_one_ends() -> None:
    """Until the change the old encoding is sent, and then only the new one."""
    lane = BoundedSoundLane()
    lane.choose(SHORT)
    lane.put(SHORT, _sound(1))
    lane.choose(LONG, 3 * 960)
    assert lane.encoding == LONG
    assert lane.encodings == (SHORT, LONG)
    lane.put(LONG, _sound(0, LONG))
    for number in (2, 3, 4):
        lane.put(SHORT, _sound(number))
    lane.put(LONG, _sound(3, LONG))
    assert len(lane.encodings) == 1
    assert _numbers(_take(lane, 3)) == [1, 2, 3]


def test_a_change_that_is_taken_back_changes_nothing() -> None:
    """A viewer who goes back to the encoding they still hear keeps hearing it."""
    lane = BoundedSoundLane()
    lane.choose(SHORT)
    lane.put(SHORT, _sound(1))
    lane.choose(LONG, 3 * 960)
    lane.choose(SHORT, 5 * 960)
    for number in (2, 3, 4, 5, 6):
        lane.put(SHORT, _sound(number))
    assert _numbers(_take(lane, 6)) == [1, 2, 3, 4, 5, 6]


def test_no_sound_means_nothing_waits() -> None:
    """A viewer who does not want sound gets none, not even what was queued."""
    lane = BoundedSoundLane()
    lane.choose(SHORT)
    lane.put(SHORT, _sound(1))
    lane.choose(None)
    lane.put(SHORT, _sound(2))
    assert lane.encoding is None
    lane.choose(LONG)
    lane.put(LONG, _sound(6, LONG))
    assert _numbers(_take(lane, 1)) == [6]


def test_old_sound_goes_first() -> None:
    """A viewer who takes no sound keeps the newest second of it, and the loss is counted."""
    lane = BoundedSoundLane()
    lane.choose(SHORT)
    for number in range(200):
        lane.put(SHORT, _sound(number))
    assert _numbers(_take(lane, 1)) == [150]
    assert lane.dropped == 150


@given(st.sets(st.integers(0, 30)), st.integers(0, 9))
def test_what_is_sent_again_ends_where_the_packet_begins(lost: set[int], count: int) -> None:
    """Repeated packets are at most as many as requested, in order and contiguous."""
    lane = BoundedSoundLane()
    lane.choose(SHORT)
    numbers = [n for n in range(32) if n not in lost]
    for number in numbers:
        lane.put(SHORT, _sound(number))
    last = _take(lane, len(numbers))[-1]
    again = _numbers(_earlier(lane, last, count))
    assert len(again) <= count
    assert again == list(range(31 - len(again), 31))
    if len(again) < min(count, 7):
        assert 30 - len(again) in lost or 30 - len(again) < 0


def test_what_is_sent_again_is_of_the_same_encoding() -> None:
    """A packet repeats none of another encoding, and none beyond the 14-bit time offset."""
    lane = BoundedSoundLane()
    lane.choose(SHORT)
    for number in (0, 1, 2):
        lane.put(SHORT, _sound(number))
    lane.choose(LONG, 3 * 960)
    for number in range(3, 30, 3):
        lane.put(LONG, _sound(number, LONG))
    sounds = _take(lane, 4)
    assert _earlier(lane, sounds[2], 9) == tuple(sounds[:2])
    assert _earlier(lane, sounds[3], 9) == ()
    lane = BoundedSoundLane()
    lane.choose(LONG)
    for number in range(0, 30, 3):
        lane.put(LONG, _sound(number, LONG))
    sounds = _take(lane, 10)
    assert _earlier(lane, sounds[9], 9) == tuple(sounds[4:9])
    assert _earlier(lane, sounds[8], 1) == (sounds[7],)


def test_news_are_told_of() -> None:
    """The newest callback is called for new packets, and an empty lane gives None."""
    lane = BoundedSoundLane()
    told: list[str] = []
    lane.choose(SHORT)
    for who in ("first", "second"):
        lane.set_listener(partial(told.append, who))
    assert lane.pop_next() is None
    lane.put(SHORT, _sound(0))
    assert told == ["second"]
    lane.put(LONG, _sound(3, LONG))
    assert told == ["second"]
    assert _numbers(_take(lane, 2)) == [0]
