"""The sums: a wrong figure in the report is worse than none."""

from __future__ import annotations

from typing import Any

import pytest

from e2e.delay.readings import Connections, Pictures, PlayerSound, Readings, SetPoints
from e2e.instrument.instrument import Instrument
from e2e.instrument.pauses import concealed_pauses, tone_pauses
from e2e.instrument.stamps import whole_ms
from e2e.instrument.sums import drift_per_min, figures, window
from e2e.instrument.synthetic import (
    ARRIVED_BEFORE_MS,
    OPENED_MS,
    blocks,
    counters,
    pictures,
    readings,
    shown,
)
from e2e.measure.ear import Ear
from e2e.measure.errors import MeasureError

END_MS = OPENED_MS + 60_000


def summed(page: Readings, *, to_ms: float | None = None) -> Any:
    return figures(page, window(page, to_ms=to_ms))


def test_of_nothing_there_is_nothing() -> None:
    """A page that showed and played nothing has no figures; nor has one of 2 s, 3 to settle."""
    page = Readings(opened_ms=OPENED_MS)
    within = window(page)
    assert within.from_ms == within.to_ms == within.sound_from_ms == OPENED_MS + 3000
    assert summed(page) == {}
    unsettled = {"picture_age_p50_ms", "sound_age_p50_ms", "pictures_per_s"}
    assert unsettled.isdisjoint(summed(readings(2)))


@pytest.mark.parametrize(("picture_ms", "sound_ms"), [(80, 123), (200, 90)])
def test_a_perfect_page_is_read_as_what_it_is(picture_ms: float, sound_ms: float) -> None:
    """Ages, arrival, skew, rate and freeze are the true ones; nothing drifts, nothing pauses.

    Sound earlier than its picture has a negative skew, whose size is judged.
    """
    found = summed(readings(20, picture_age_ms=picture_ms, sound_age_ms=sound_ms))
    assert found["picture_age_p50_ms"] == found["picture_age_p95_ms"] == picture_ms
    assert found["arrival_age_p95_ms"] == picture_ms - ARRIVED_BEFORE_MS
    assert found["sound_age_p50_ms"] == pytest.approx(sound_ms, abs=0.5)
    skew_ms = sound_ms - picture_ms
    assert found["skew_p50_ms"] == pytest.approx(skew_ms, abs=0.5)
    assert found["joined_skew_p95_ms"] == pytest.approx(abs(skew_ms), abs=0.5)
    assert found["pictures_per_s"] == pytest.approx(25, abs=0.2)
    assert found["longest_freeze_ms"] == pytest.approx(40)
    assert found["picture_drift_ms_per_min"] == pytest.approx(0, abs=0.1)
    assert found["sound_drift_ms_per_min"] == pytest.approx(0, abs=0.1)
    assert (found["pauses"], found["pauses_per_min"], found["longest_pause_ms"]) == (0, 0, 0)
    assert {"command_round_trip_p50_ms", "set_points_per_s", "breaks"}.isdisjoint(found)


def test_skew_counts_from_three_seconds_after_joining() -> None:
    """Skew in the first 3 s is ignored, and any later skew counts."""
    page = readings(20, picture_age_ms=80, sound_age_ms=120)
    late = page.model_copy(update={"first_picture_ms": OPENED_MS + 60_000})
    assert "joined_skew_p95_ms" in figures(page, window(page, settle_s=10))
    assert "joined_skew_p95_ms" not in figures(late, window(page))


@pytest.mark.parametrize("age_ms", [3.0, 480.0, 999.0, 1001.0, 1430.0, 2600.0])
def test_sound_may_be_older_than_a_second(age_ms: float) -> None:
    """A burst does not say which second it is of; the pictures at the same time do."""
    found = summed(readings(10, picture_age_ms=age_ms + 60, sound_age_ms=age_ms))
    assert found["sound_age_p50_ms"] == pytest.approx(age_ms, abs=0.5)


def test_sound_is_no_younger_than_the_jitter_buffer_held_it() -> None:
    """With 1.1 s in the jitter buffer an age of 1.3 s is not read as 0.3, near the picture's."""
    page = readings(10, picture_age_ms=200, sound_age_ms=1300)
    page.counters = counters([(0, 0)] * 100)
    page.counters.sound_buffer_ms = [1100.0] * 100
    assert summed(page)["sound_age_p50_ms"] == pytest.approx(1300, abs=0.5)


def test_sound_that_falls_behind_is_followed_over_the_second() -> None:
    """From 0.9 s the age grows by 50 ms a second to 1.9 s: a drift of 3000 ms a minute, no jump."""
    page = readings(1)
    page.pictures = Pictures()
    page.sound = blocks(21, 900)
    page.sound.start_ms = [at + 0.05 * (at - OPENED_MS) for at in page.sound.start_ms]
    found = summed(page)
    assert found["sound_age_p95_ms"] - found["sound_age_p50_ms"] > 350
    assert found["sound_drift_ms_per_min"] == pytest.approx(60 * 1000 * 0.05 / 1.05, rel=0.02)


def test_unreadable_pictures_have_no_age_but_are_pictures() -> None:
    """With every other card unreadable, ages stay the same, and the rate counts all changes."""
    page = readings(10)
    page.pictures.stamp_ms[::2] = [None] * len(page.pictures.stamp_ms[::2])
    found = summed(page)
    assert found["picture_age_p95_ms"] == 80
    assert found["pictures_per_s"] == pytest.approx(25, abs=0.2)


def test_the_same_picture_again_is_no_other() -> None:
    """A card that stays for a second, however often presented, is a freeze of a second."""
    page = readings(10)
    stamps = page.pictures.stamp_ms
    stamps[126:150] = [stamps[125]] * 24
    found = summed(page)
    assert found["longest_freeze_ms"] == pytest.approx(1000)
    assert found["pictures_per_s"] == pytest.approx(25 - 24 / 7, abs=0.2)


def test_a_freeze_at_the_end_counts_to_the_end() -> None:
    """A picture that freezes for the last 4 of 12 s while the sound plays counts as a freeze."""
    page = readings(12)
    page.pictures = pictures(8, 80)
    assert summed(page)["longest_freeze_ms"] == pytest.approx(4000, abs=60)
    assert summed(page, to_ms=OPENED_MS + 20_000)["longest_freeze_ms"] == pytest.approx(12_040)


def test_a_rate_is_of_pictures_of_that_size() -> None:
    """Smaller pictures do not count for the larger size; without large ones the rate is 0."""
    page = readings(20).model_copy(update={"pictures": shown((10, 30, 50, 640), (20, 10, 50, 320))})
    found = figures(page, window(page, settle_s=0))
    assert found["pictures_640_per_s"] == pytest.approx(15, abs=0.1)
    assert found["pictures_160_per_s"] == pytest.approx(20, abs=0.1)
    small = page.model_copy(update={"pictures": shown((20, 10, 50, 320))})
    assert summed(small)["pictures_640_per_s"] == 0


def test_a_break_is_seen() -> None:
    """Always connected is 0; each later change counts, and so does an end without pictures."""
    page = readings(10)
    states = ["connecting", "connected", "disconnected", "connected"]
    for number, expected in ((2, 0), (4, 2)):
        page.connections = Connections(at_ms=[0.0] * number, state=states[:number])
        assert summed(page)["breaks"] == expected
        assert summed(page, to_ms=END_MS)["breaks"] == expected + 1


def test_driving_is_seen() -> None:
    """The rate of set-points is over the measured time."""
    page = readings(10)
    page.set_points = SetPoints(at_ms=[OPENED_MS + 50 * number for number in range(400)])
    assert summed(page)["set_points_per_s"] == pytest.approx(20, abs=0.2)


def test_a_pause_in_the_tone_is_found_and_a_blink_is_not() -> None:
    """50 ms without tone and burst are a pause, 20 ms are none; the burst covers its own tone."""
    sound = blocks(10, 120)
    for begin, end in ((400, 405), (500, 502), (612, 622)):
        sound.tone[begin:end] = [0.0] * (end - begin)
    assert tone_pauses(sound, OPENED_MS, END_MS - 50_000) == [(OPENED_MS + 4000, 50)]


def test_time_that_has_no_blocks_is_a_pause_too() -> None:
    """Blocks that are missing in the middle, or for the last 3 of 13 s, are pauses."""
    sound = blocks(10, 120)
    for column in (sound.start_ms, sound.tone, sound.burst):
        del column[450:470]
    found = tone_pauses(sound, OPENED_MS, OPENED_MS + 13_000)
    assert found == [(OPENED_MS + 4500, 200), (OPENED_MS + 10_000, 3000)]


def test_late_sound_is_judged_from_its_own_settling_on() -> None:
    """Sound first heard after 5 s counts from 8 s on; first heard after 12 of 13 s, never."""
    page = readings(20)
    page.first_sound_ms = OPENED_MS + 5000
    for begin in (600, 900):
        page.sound.tone[begin : begin + 20] = [0.0] * 20
        page.sound.burst[begin : begin + 20] = [0.0] * 20
    within, found = window(page), summed(page)
    assert (within.from_ms, within.sound_from_ms) == (OPENED_MS + 3000, OPENED_MS + 8000)
    minutes = (within.to_ms - within.sound_from_ms) / 60_000
    assert found["pauses_per_min"] == pytest.approx(1 / minutes)
    assert (found["longest_pause_ms"], found["pauses"]) == (200, 2)
    page.first_sound_ms = OPENED_MS + 12_000
    found = summed(page, to_ms=OPENED_MS + 13_000)
    assert {"pauses_per_min", "sound_age_p50_ms"}.isdisjoint(found)


def test_pauses_are_cut_to_the_window() -> None:
    """Of 2 s of silence around the window's start, only the part inside counts."""
    sound = blocks(10, 120)
    sound.tone[200:400] = [0.0] * 200
    sound.burst[200:400] = [0.0] * 200
    found = tone_pauses(sound, OPENED_MS + 3000, OPENED_MS + 10_000)
    assert found == [(OPENED_MS + 3000, 1000)]


@pytest.mark.parametrize("rate_hz", [8000, 48_000])
def test_one_concealment_over_several_looks_is_one_pause(rate_hz: int) -> None:
    """60 ms at the end of a look, two whole looks and 30 ms make 290 ms, at either codec's rate."""
    looks = [(0.0, 0)] * 20
    looks[5:9] = [(60, 1), (100, 0), (100, 0), (30, 0)]
    found = concealed_pauses(counters(looks, rate_hz=rate_hz), OPENED_MS, END_MS)
    assert found == [pytest.approx((OPENED_MS + 440, 290), rel=0, abs=0.01)]


def test_many_short_concealments_are_no_long_one() -> None:
    """Two of 40 ms in each of ten looks are no pause of 100, though 800 ms were concealed."""
    looks = [(0.0, 0)] * 5 + [(80.0, 2)] * 10 + [(0.0, 0)] * 5
    assert concealed_pauses(counters(looks), OPENED_MS, END_MS) == []


def test_concealment_broken_for_a_packet_is_one_pause() -> None:
    """If 95 % of a look was concealed, nothing audible came between its two events."""
    looks = [(0.0, 0)] * 5 + [(90.0, 1), (95.0, 1), (100.0, 0)] + [(0.0, 0)] * 5
    found = concealed_pauses(counters(looks), OPENED_MS, END_MS)
    assert [length_ms for _, length_ms in found] == [pytest.approx(285)]


def test_concealment_counts_from_the_first_sound() -> None:
    """In the 2 s after the first sound 100 ms were concealed; what came earlier does not count."""
    rows = [(100.0, 1)] * 10 + [(0.0, 0)] * 10 + [(100.0, 1)] + [(0.0, 0)] * 10
    page = Readings(opened_ms=OPENED_MS, first_sound_ms=OPENED_MS + 1000, counters=counters(rows))
    assert summed(page, to_ms=END_MS)["concealed_percent"] == pytest.approx(5, abs=0.5)
    silent = page.model_copy(update={"first_sound_ms": None})
    assert "concealed_percent" not in summed(silent, to_ms=END_MS)


def test_the_built_in_players_counts_come_before_the_browsers() -> None:
    """While the page plays by itself, the browser counts nothing of what is heard."""
    page = readings(20)
    seconds = [*range(12), *range(8)]  # it was restarted once, and counts from zero
    page.player_sound = PlayerSound(
        at_ms=[OPENED_MS + 1000.0 * second for second in range(20)],
        played_ms=[1000.0 * second for second in seconds],
        concealed_ms=[20.0 * second for second in seconds],
        stretched_ms=[5.0 * second for second in seconds],
    )
    found = summed(page)
    assert found["concealed_percent"] == pytest.approx(2)
    assert found["stretched_percent"] == pytest.approx(0.5)


def test_bytes_are_a_rate() -> None:
    """1000 bytes a look are 10 kB a second; without a count there is no figure."""
    page = readings(10)
    page.counters = counters([(0, 0)] * 100)
    page.counters.received_bytes = [float(n * 1000) for n in range(100)]
    found = summed(page)
    assert found["received_kb_per_s"] == pytest.approx(10)
    assert "sent_kb_per_s" not in found


def test_drift_is_not_moved_by_outliers() -> None:
    """A steady 6 ms a minute stays that with a tenth of the values a second off."""
    at_ms = [100.0 * n for n in range(600)]
    values = [at / 10_000 + (1000 if n % 10 == 3 else 0) for n, at in enumerate(at_ms)]
    series = list(zip(at_ms, values, strict=True))
    assert drift_per_min(series) == pytest.approx(6, abs=0.1)
    assert drift_per_min(series[:40]) is None


@pytest.mark.parametrize("at_ms", [5 * 2**40 + 30.5, 5 * 2**40 - 30.5, 1_800_000_000_000.0])
def test_a_stamp_of_40_bits_is_completed_about_its_wrap(at_ms: float) -> None:
    """The stamp is 100 ms before its presentation, on either side of a multiple of 2⁴⁰ ms.

    One that is hours off is no card: one picture in 256 has the right check by chance.
    """
    assert whole_ms((int(at_ms) - 100) % 2**40, at_ms) == int(at_ms) - 100
    assert whole_ms((int(at_ms) - 3 * 3_600_000) % 2**40, at_ms) is None


async def test_a_page_without_the_instrument_is_told() -> None:
    """If the page never had the instrument, the error is a sentence, not an empty table."""

    async def nothing(expression: str) -> None:
        assert "take" in expression

    with pytest.raises(MeasureError, match="PRELOAD"):
        await Instrument(nothing, Ear({})).readings()
