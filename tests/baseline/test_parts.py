"""The parts of the thesis's sender: settings, slot, cache, T_r, fail-safe, virtual clock."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from wax.baseline.fail_safe import BaselineFailSafe, LinkMeasurements, insufficient
from wax.baseline.media_units import MediaUnit, SourceSlot
from wax.baseline.picture_cache import PictureCache
from wax.baseline.transfer_time import LeastRoundTrip, TransferTime
from wax.baseline.virtual_clock import VirtualClock
from wax.config.thesis import ThesisSettings

SETTINGS = ThesisSettings()


def _picture(number: int) -> MediaUnit:
    return MediaUnit("picture", number, captured_s=number / 10, duration_s=0.1)


def _sound(number: int) -> MediaUnit:
    return MediaUnit("sound", number, captured_s=number / 2, duration_s=0.5)


# --- settings ------------------------------------------------------------------------------


def test_the_defaults_are_the_thesiss() -> None:
    """4 kB of sound and 8 kB of picture, for which 3.5 asks 704 kbit/s."""
    sound_bytes_per_s = SETTINGS.sample_rate_hz
    assert SETTINGS.audio_mu_ms * sound_bytes_per_s == 4000 * 1000
    pictures_per_s = 1000 / SETTINGS.video_mu_ms
    assert 8 * (SETTINGS.picture_bytes * pictures_per_s + sound_bytes_per_s) == 704_000


@pytest.mark.parametrize("audio_mu_ms", [100, 200, 300, 400, 500])
def test_the_thesiss_lengths_are_allowed(audio_mu_ms: int) -> None:
    """Chapter 5 goes from 100 to 500 ms by 100."""
    assert ThesisSettings(audio_mu_ms=audio_mu_ms).audio_mu_ms == audio_mu_ms


@pytest.mark.parametrize(
    ("audio_mu_ms", "video_mu_ms"), [(450, 100), (50, 50), (600, 100), (200, 400), (300, 70)]
)
def test_other_lengths_are_refused(audio_mu_ms: int, video_mu_ms: int) -> None:
    """The audio MU is 100 to 500 ms and a whole multiple of the video MU."""
    with pytest.raises(ValidationError, match="audio_mu_ms"):
        ThesisSettings(audio_mu_ms=audio_mu_ms, video_mu_ms=video_mu_ms)


# --- source slot ---------------------------------------------------------------------------


def test_the_next_sound_replaces_the_one_that_waits() -> None:
    """The replaced MU is returned, and only the newest can be taken, once."""
    slot = SourceSlot(longest_wait_s=0.5)
    assert slot.put(_sound(0), 0.5) is None
    assert slot.put(_sound(1), 1.0) == _sound(0)
    assert slot.take() == _sound(1)
    assert slot.take() is None


def test_a_sound_waits_no_longer_than_its_length() -> None:
    """A sound expires after one MU length."""
    slot = SourceSlot(longest_wait_s=0.5)
    slot.put(_sound(0), 0.5)
    assert slot.expire(1.0) is None
    assert slot.expire(1.0001) == _sound(0)
    assert slot.held is None


# --- cache ---------------------------------------------------------------------------------


def test_a_cached_picture_stays_until_its_place_is_sent() -> None:
    """The newest waits beside a full cache, and enters when a place is empty."""
    cache = PictureCache()
    cache.resize(2)
    assert cache.put(_picture(0), 0.1) == []
    assert cache.put(_picture(1), 0.2) == []
    assert cache.put(_picture(2), 0.3) == []
    assert cache.put(_picture(3), 0.4) == [_picture(2)]
    assert cache.take_oldest() == _picture(0)
    cache.fill()
    assert cache.pictures == (_picture(1), _picture(3))
    assert cache.newest is None


def test_a_smaller_cache_keeps_the_newest() -> None:
    """A shrinking cache skips the oldest and keeps the newest."""
    cache = PictureCache()
    cache.resize(4)
    for number in range(4):
        cache.put(_picture(number), number / 10)
    assert cache.resize(1) == [_picture(0), _picture(1), _picture(2)]
    assert cache.resize(0) == []
    assert cache.newest == _picture(3)
    assert cache.take_oldest() == _picture(3)
    assert cache.take_oldest() is None


operations = st.lists(st.sampled_from(["put", "take", 0, 1, 2, 4, 9]), max_size=60)


@given(operations)
def test_every_picture_is_taken_or_skipped_once_and_in_order(steps: list[str | int]) -> None:
    """Each picture is taken or skipped once, in order, and at most capacity + 1 are held."""
    cache = PictureCache()
    put = 0
    taken: list[int] = []
    skipped: list[int] = []
    for step in steps:
        if step == "put":
            skipped += [mu.number for mu in cache.put(_picture(put), put / 10)]
            put += 1
        elif step == "take":
            mu = cache.take_oldest()
            cache.fill()
            taken += [] if mu is None else [mu.number]
        elif isinstance(step, int):
            skipped += [mu.number for mu in cache.resize(step)]
        held = [mu.number for mu in cache.pictures]
        held += [] if cache.newest is None else [cache.newest.number]
        assert len(held) <= cache.capacity + 1
        assert held == sorted(held)
        assert sorted([*taken, *skipped, *held]) == list(range(put))
    assert taken == sorted(taken)


# --- T_r -----------------------------------------------------------------------------------


def _measured(*intervals_s: float, round_trip_s: float = 0.0) -> TransferTime:
    round_trip = LeastRoundTrip()
    round_trip.seen(round_trip_s)
    transfer = TransferTime(round_trip, lost_after_s=5.0)
    for number, interval_s in enumerate(intervals_s):
        transfer.left(_picture(number), number * 100.0)
        transfer.acknowledged(number, number * 100.0 + interval_s)
    return transfer


def test_the_least_round_trip_is_not_part_of_the_transfer() -> None:
    """T_r is first packet to acknowledgement less the least round trip, and never negative."""
    assert _measured(0.25, round_trip_s=0.1).seconds == pytest.approx(0.15)
    assert _measured(0.05, round_trip_s=0.1).seconds == 0.0


def test_only_the_least_round_trip_counts() -> None:
    """Longer or invalid round trips change nothing."""
    round_trip = LeastRoundTrip()
    for seen_s in (0.2, 0.1, 0.3, 0.0, -1.0):
        round_trip.seen(seen_s)
    assert round_trip.seconds == 0.1


def test_the_first_measurement_counts_alone_and_later_one_spike_does_not() -> None:
    """At start-up T_r is V_2's; then one late picture is jitter and two are the link."""
    assert _measured(0.3).seconds == pytest.approx(0.3)
    assert _measured(0.02, 0.02, 0.9).seconds == pytest.approx(0.02)
    assert _measured(0.02, 0.9, 0.9).seconds == pytest.approx(0.9)


def test_what_is_under_way_already_shows_that_it_takes_long() -> None:
    """T_r is at least the time that the picture in flight has taken, from the first on."""
    transfer = _measured()
    assert transfer.at_least_s(0.0) is None
    transfer.left(_picture(0), 10.0)
    assert transfer.at_least_s(10.7) == pytest.approx(0.7)
    slow = _measured(0.02, 0.02, 0.9)
    slow.left(_picture(9), 400.0)
    assert slow.at_least_s(400.01) == pytest.approx(0.02)
    assert slow.at_least_s(400.8) == pytest.approx(0.8)


def test_only_the_one_under_way_can_be_acknowledged() -> None:
    """Another number, or a repeated one, is ignored."""
    transfer = _measured()
    transfer.left(_picture(3), 1.0)
    assert transfer.acknowledged(2, 1.1) is None
    assert transfer.acknowledged(3, 1.2) == _picture(3)
    assert transfer.acknowledged(3, 1.3) is None
    assert transfer.seconds == pytest.approx(0.2)


def test_nothing_leaves_beside_the_one_under_way() -> None:
    """Sending a second MU raises."""
    transfer = _measured()
    transfer.left(_picture(0), 1.0)
    with pytest.raises(RuntimeError, match="still in flight"):
        transfer.left(_picture(1), 1.1)


def test_what_is_never_acknowledged_is_lost_in_the_end() -> None:
    """An MU is lost after 5 s on an unknown link, else after 4 T_r, but not before 1 s."""
    unknown = _measured()
    unknown.left(_picture(0), 1.0)
    assert unknown.give_up(5.999) is None
    assert unknown.give_up(6.0) == _picture(0)
    assert unknown.under_way is None
    fast = _measured(0.01)
    fast.left(_picture(5), 500.0)
    assert fast.give_up_s() == pytest.approx(501.0)
    modem = _measured(0.9)
    modem.left(_picture(5), 500.0)
    assert modem.give_up_s() == pytest.approx(503.6)


# --- fail-safe -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("measured", "enough"),
    [
        (LinkMeasurements(), True),
        (LinkMeasurements(transfer_s=0.499), True),
        (LinkMeasurements(transfer_s=0.5), False),  # T_r = A, under (3.4)
        (LinkMeasurements(interval_s=1.0), True),  # one a second is not less than one
        (LinkMeasurements(interval_s=1.001), False),
        (LinkMeasurements(sound_delay_s=0.5), True),  # "longer than the audio MU"
        (LinkMeasurements(sound_delay_s=0.501), False),
    ],
)
def test_each_condition_at_its_boundary(measured: LinkMeasurements, enough: bool) -> None:
    """T_r >= A, less than one picture a second, or sound later than one MU: each suffices."""
    assert (insufficient(measured, SETTINGS) is None) == enough


def test_fail_safe_is_entered_at_once_and_left_after_a_good_second() -> None:
    """A relapse within the second restarts it."""
    fail_safe = BaselineFailSafe(SETTINGS)
    fail_safe.update(LinkMeasurements(transfer_s=0.6), 1.0)
    assert fail_safe.is_active
    fail_safe.update(LinkMeasurements(transfer_s=0.1), 2.0)
    fail_safe.update(LinkMeasurements(transfer_s=0.6), 2.9)
    fail_safe.update(LinkMeasurements(transfer_s=0.1), 3.0)
    fail_safe.update(LinkMeasurements(transfer_s=0.1), 3.99)
    assert fail_safe.is_active
    fail_safe.update(LinkMeasurements(transfer_s=0.1), 4.0)
    assert not fail_safe.is_active


# --- virtual clock -------------------------------------------------------------------------


def test_the_clock_is_one_audio_mu_behind_when_the_sound_leaves_at_once() -> None:
    """The cache is then N_v, and N_v pictures fill the hold-back of V_2."""
    clock = VirtualClock(SETTINGS, _sound(0), now_s=0.5)
    assert clock.rollback_s == 0.5
    assert clock.due_s(_picture(0)) == _picture(0).captured_s + 0.5
    assert clock.hold_back_s(_picture(4)) == pytest.approx(0.4)
    assert clock.capacity(0.0) == 4
    assert clock.capacity(0.2) == 1
    assert clock.capacity(0.5) == 0


def test_a_longer_roll_back_gets_a_longer_cache() -> None:
    """206 ms for the client of 5.3.1 are three places at full rate and one at 200 ms a picture."""
    clock = VirtualClock(SETTINGS, _sound(0), now_s=0.5)
    clock.extra_s = 0.206
    assert clock.capacity(0.05) == 7
    assert clock.capacity(0.2) == 2
    assert clock.capacity(0.6) == 0
    assert clock.due_s(_picture(4)) == pytest.approx(0.4 + 0.706)


def test_the_roll_back_is_bounded() -> None:
    """Sound that is delivered seconds late rolls the picture back by at most two MUs."""
    assert VirtualClock(SETTINGS, _sound(0), now_s=60.0).rollback_s == 1.0
