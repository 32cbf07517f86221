"""The audio-master policy: the picture meets the sound, within its bound, whatever comes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.config import SyncSettings
from wax.sync.audio_master import AudioMaster
from wax.sync.playout import PlayoutReport, StreamPlayout
from wax.sync.policies import make_policy

OBSERVER = SyncSettings()
OPERATOR = SyncSettings(max_holdback_ms=50.0, max_skew_ms=100.0)

ages = st.none() | st.floats(-1e15, 1e15)
streams = st.none() | st.builds(StreamPlayout, age_ms=ages, delay_ms=ages)
reports = st.builds(PlayoutReport, sound=streams, picture=streams)


class Browser:
    """A model of a page: a picture buffer that obeys at once, a sound buffer that ramps."""

    def __init__(self, *, sound_ms: float, picture_path_ms: float, sound_path_ms: float) -> None:
        self.sound_ms = sound_ms
        self.picture_ms = 0.0
        self._picture_path_ms = picture_path_ms
        self._sound_path_ms = sound_path_ms

    def report(self) -> PlayoutReport:
        return PlayoutReport(
            sound=StreamPlayout(self._sound_path_ms + self.sound_ms, self.sound_ms),
            picture=StreamPlayout(self._picture_path_ms + self.picture_ms, self.picture_ms),
        )

    @property
    def skew_ms(self) -> float:
        return self._sound_path_ms + self.sound_ms - self._picture_path_ms - self.picture_ms


def _run(policy: AudioMaster, browser: Browser, seconds: float, start_s: float = 0.0) -> None:
    for tick in range(int(seconds * 4)):
        targets = policy.decide(browser.report(), start_s + tick / 4)
        browser.picture_ms = max(targets.picture_ms or 0.0, 8.0)


@given(
    st.floats(20, 300),
    st.floats(0, 150),
    st.floats(0, 150),
)
def test_an_observers_picture_meets_the_sound(
    sound_ms: float, picture_path_ms: float, sound_path_ms: float
) -> None:
    """Within 3 s the skew is at most 20 ms wherever holding back the picture can make it so."""
    browser = Browser(
        sound_ms=sound_ms, picture_path_ms=picture_path_ms, sound_path_ms=sound_path_ms
    )
    possible = browser.skew_ms >= 8.0
    _run(AudioMaster(OBSERVER), browser, 3.0)
    if possible:
        assert abs(browser.skew_ms) <= 20.0


@given(st.floats(-0.075, 0.075))
def test_the_picture_follows_a_sound_that_drifts(slope: float) -> None:
    """While a browser stretches its sound by 75 ms a second the picture stays beside it."""
    browser = Browser(sound_ms=300, picture_path_ms=20, sound_path_ms=30)
    policy = AudioMaster(OBSERVER)
    _run(policy, browser, 4.0)
    for tick in range(12):
        browser.sound_ms += slope * 250
        _run(policy, browser, 0.25, 4.0 + tick / 4)
        assert abs(browser.skew_ms) <= 45.0


@given(st.lists(st.tuples(reports, st.floats(0, 10)), max_size=30), st.sampled_from([0, 50, 500]))
def test_the_bound_holds_whatever_is_reported(
    trace: list[tuple[PlayoutReport, float]], ceiling: int
) -> None:
    """No report, however wrong, holds the picture back beyond the bound or below zero."""
    policy = AudioMaster(SyncSettings(max_holdback_ms=float(ceiling)))
    now_s = 0.0
    for report, step_s in trace:
        now_s += step_s
        targets = policy.decide(report, now_s)
        assert targets.picture_ms is not None
        assert 0 <= targets.picture_ms <= ceiling


@given(st.lists(reports, max_size=30), st.sampled_from(["auto", 20.0, 200.0, 500.0]))
def test_the_sound_never_waits_for_the_picture(
    trace: list[PlayoutReport], delay: float | str
) -> None:
    """Whatever the picture does, the sound's target stays the configured one."""
    policy = AudioMaster(SyncSettings.model_validate({"audio_delay_ms": delay}))
    expected = None if delay == "auto" else delay
    assert policy.start().sound_ms == expected
    for tick, report in enumerate(trace):
        assert policy.decide(report, tick / 4).sound_ms == expected


def test_a_set_delay_holds_both_streams_from_the_first_moment() -> None:
    """With a set delay the picture does not wait for a measurement to be held back."""
    targets = AudioMaster(SyncSettings(audio_delay_ms=400.0)).start()
    assert (targets.sound_ms, targets.picture_ms) == (400.0, 400.0)
    assert AudioMaster(SyncSettings(audio_delay_ms=400.0)).preroll_ms == 400.0


def test_the_operators_picture_waits_at_most_its_bound() -> None:
    """Beyond 50 ms delivery wins, and the reason says so."""
    policy = AudioMaster(OPERATOR)
    browser = Browser(sound_ms=400, picture_path_ms=20, sound_path_ms=30)
    _run(policy, browser, 3.0)
    assert browser.picture_ms == 50.0
    assert "as long as allowed" in policy.decide(browser.report(), 9.0).reason


def test_without_sound_the_picture_waits_for_nothing() -> None:
    """Only video asked for: as soon as possible (thesis 3.3)."""
    policy = AudioMaster(SyncSettings(audio_delay_ms=300.0))
    targets = policy.decide(PlayoutReport(sound=None, picture=StreamPlayout(40, 8)), 1.0)
    assert targets.picture_ms == 0.0


def test_a_browser_that_tells_no_ages_is_followed_by_its_buffers() -> None:
    """Where RTP times are not told, the picture follows the sound's measured buffer delay."""
    policy = AudioMaster(OBSERVER)
    delay_ms = 8.0
    for tick in range(12):
        report = PlayoutReport(StreamPlayout(None, 200.0), StreamPlayout(None, delay_ms))
        delay_ms = max(policy.decide(report, tick / 4).picture_ms or 0.0, 8.0)
    assert abs(delay_ms - 200.0) <= 20.0


def test_video_first_holds_nothing_back() -> None:
    """`video-first`: neither waits for the other."""
    policy = make_policy(SyncSettings(policy="video-first", audio_delay_ms=100.0))
    report = PlayoutReport(StreamPlayout(300, 250), StreamPlayout(30, 8))
    assert policy.decide(report, 1.0) == policy.start()
    assert (policy.start().sound_ms, policy.start().picture_ms) == (100.0, 0.0)
