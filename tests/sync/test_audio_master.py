"""The audio-master policy: the picture meets the sound, within its bound, whatever happens."""

from __future__ import annotations

import random

from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.config.sync import SyncSettings
from wax.congestion.allocation import Allocation, SoundEncoding, Step
from wax.congestion.control import LinkEstimate
from wax.sync.audio_master import AudioMaster
from wax.sync.playout import PlayoutReport, StreamPlayout
from wax.sync.policies import make_policy

OBSERVER = SyncSettings()
OPERATOR = SyncSettings(max_holdback_ms=50.0, max_skew_ms=100.0)

ages = st.none() | st.floats(allow_nan=True, allow_infinity=True)
streams = st.none() | st.builds(
    StreamPlayout, age_ms=ages, delay_ms=ages, concealed_ms=ages, played_ms=ages
)
reports = st.builds(PlayoutReport, sound=streams, picture=streams)
estimates = st.none() | st.builds(
    LinkEstimate,
    state=st.sampled_from(["starting", "steady", "congested", "blind"]),
    rate_bps=ages,
    used_bps=ages,
    queue_ms=ages,
    jitter_ms=st.floats(),
    lost=st.floats(),
    burst=st.integers(),
    round_trip_ms=ages,
)
allocations = st.none() | st.builds(
    Allocation,
    step=st.none() | st.just(Step("a", "640x480", 30.0, 1_000_000, 3)),
    top_layer=st.just(2),
    sound=st.none() | st.just(SoundEncoding(60, 12_000)),
    redundancy=st.integers(0, 3),
    reason=st.just(""),
)


class Browser:
    """A model of a page: delayed reports of the last 250 ms, and an obedient picture buffer.

    The picture's buffer keeps `least_ms` on its own. Each report is off by up to `noise_ms`.
    """

    def __init__(
        self,
        policy: AudioMaster,
        *,
        sound_ms: float,
        picture_ms: float,
        least_ms: float = 8.0,
        round_trip_s: float = 0.05,
        noise_ms: float = 0.0,
        slope_ms_per_s: float = 0.0,
        seed: int = 0,
    ) -> None:
        self.policy = policy
        self.sound_ms = sound_ms
        self.slope_ms_per_s = slope_ms_per_s
        self.held: list[float] = []
        self.skews_ms: list[float] = []
        self._picture_ms = picture_ms
        self._least_ms = least_ms
        self._noise_ms = noise_ms
        self._random = random.Random(seed)
        self._one_way_s = round_trip_s / 2
        self._estimate = LinkEstimate("steady", 1e6, 1e5, 0.0, 3.0, 0.0, 0, round_trip_s * 1000)
        self._tick = 0
        self._holds: list[tuple[float, float]] = [(0.0, 0.0)]
        self._reports: list[tuple[float, PlayoutReport]] = []

    def play(self, seconds: float) -> None:
        """Advance time in steps of 10 ms."""
        for _ in range(int(seconds * 100)):
            self._tick += 1
            now_s = self._tick / 100
            held_ms = next(ms for from_s, ms in reversed(self._holds) if from_s <= now_s)
            self.sound_ms += self.slope_ms_per_s / 100
            shown_ms = self._picture_ms + max(held_ms, self._least_ms)
            self.skews_ms.append(self.sound_ms - shown_ms)
            if self._tick % 25 == 0:
                late_ms = sum(self.skews_ms[-25:]) / 25
                late_ms += self._random.uniform(-self._noise_ms, self._noise_ms)
                report = PlayoutReport(StreamPlayout(400.0 + late_ms), StreamPlayout(400.0))
                self._reports.append((now_s + self._one_way_s, report))
            while self._reports and self._reports[0][0] <= now_s:
                targets = self.policy.decide(self._reports.pop(0)[1], now_s, self._estimate)
                assert targets.picture_ms is not None
                self.held.append(targets.picture_ms)
                if targets.picture_ms != self._holds[-1][1]:
                    self._holds.append((now_s + self._one_way_s + 0.02, targets.picture_ms))

    @property
    def changes(self) -> int:
        return len(self._holds) - 1


def _told(sound_ms: float | None, picture_ms: float | None) -> PlayoutReport:
    return PlayoutReport(StreamPlayout(age_ms=sound_ms), StreamPlayout(age_ms=picture_ms))


@examples(60)
@given(
    early_ms=st.floats(0, 450),
    least_ms=st.floats(0, 30),
    round_trip_s=st.floats(0, 0.7),
    noise_ms=st.floats(0, 8),
    seed=st.integers(0, 9),
)
def test_an_observers_picture_meets_the_sound_and_stays_there(
    early_ms: float, least_ms: float, round_trip_s: float, noise_ms: float, seed: int
) -> None:
    """Three seconds after joining, sound and picture are within 14 ms, even over a satellite."""
    browser = Browser(
        AudioMaster(OBSERVER),
        sound_ms=early_ms + least_ms,
        picture_ms=0.0,
        least_ms=least_ms,
        round_trip_s=round_trip_s,
        noise_ms=noise_ms,
        seed=seed,
    )
    browser.play(3.0 + round_trip_s)
    changes = browser.changes
    browser.play(60.0)
    late = sorted(abs(skew_ms) for skew_ms in browser.skews_ms[-6000:])
    assert late[int(0.95 * len(late))] <= 14
    assert browser.changes - changes <= 4


@examples(30)
@given(slope=st.floats(-75, 75), round_trip_s=st.floats(0, 0.1))
def test_the_picture_follows_a_sound_that_drifts(slope: float, round_trip_s: float) -> None:
    """While a browser stretches its sound by 75 ms a second the picture stays in step."""
    browser = Browser(
        AudioMaster(OBSERVER), sound_ms=250.0, picture_ms=20.0, round_trip_s=round_trip_s
    )
    browser.play(4.0)
    browser.slope_ms_per_s = slope
    browser.play(2.5)
    assert max(abs(skew_ms) for skew_ms in browser.skews_ms[-250:]) <= 70
    browser.slope_ms_per_s = 0.0
    browser.play(3.0)
    assert abs(browser.skews_ms[-1]) <= 14


@given(st.floats(-400, 80), st.floats(0, 5), st.integers(0, 9))
def test_an_operator_with_nothing_to_wait_for_waits_for_nothing(
    early_ms: float, noise_ms: float, seed: int
) -> None:
    """Sound that is up to 80 ms late, or early, always gives a hold-back of exactly 0."""
    browser = Browser(
        AudioMaster(OPERATOR),
        sound_ms=early_ms + 8,
        picture_ms=0.0,
        noise_ms=noise_ms,
        seed=seed,
    )
    browser.play(20.0)
    assert set(browser.held) == {0.0}


@given(st.floats(110, 130))
def test_an_operators_picture_is_held_back_just_as_much_as_brings_the_skew_inside(
    early_ms: float,
) -> None:
    """A skew beyond 100 ms is reduced below that, but not below 60 ms."""
    browser = Browser(AudioMaster(OPERATOR), sound_ms=early_ms + 8, picture_ms=0.0)
    browser.play(10.0)
    assert 60 <= browser.skews_ms[-1] <= 100


def test_the_operators_picture_waits_at_most_its_bound() -> None:
    """The hold-back never exceeds 50 ms, and the reason says so."""
    policy = AudioMaster(OPERATOR)
    browser = Browser(policy, sound_ms=180, picture_ms=20)
    browser.play(3.0)
    targets = policy.decide(_told(180, 70), 9.0)
    assert targets.picture_ms == 50.0
    assert "as long as allowed" in str(targets.reason)


def test_a_picture_does_not_wait_in_vain() -> None:
    """Nothing is held back if the longest hold-back would leave the sound noticeably late."""
    policy = AudioMaster(OPERATOR)
    browser = Browser(policy, sound_ms=260, picture_ms=20)
    browser.play(3.0)
    targets = policy.decide(_told(260, 28), 9.0)
    assert targets.picture_ms == 0.0
    assert "too late to wait for" in str(targets.reason)


@given(st.floats(-500, 500), st.floats(-500, 500), st.sampled_from([OBSERVER, OPERATOR]))
def test_later_sound_never_means_less_hold_back(a: float, b: float, sync: SyncSettings) -> None:
    """After the first report the hold-back grows with the sound's lateness, until it is no use."""
    in_vain_ms = sync.max_holdback_ms + 125.0
    a, b = min(a, in_vain_ms), min(b, in_vain_ms)
    low, high = sorted((a, b))
    held = [AudioMaster(sync).decide(_told(500 + ms, 500), 1.0).picture_ms for ms in (low, high)]
    assert held[0] is not None
    assert held[1] is not None
    assert held[0] <= held[1]


def test_a_headset_rolls_the_picture_back_and_a_speaker_brings_it_forward() -> None:
    """The picture follows a wireless headset's 200 ms, and returns when it is removed."""
    browser = Browser(AudioMaster(OBSERVER), sound_ms=90, picture_ms=20)
    browser.play(3.0)
    browser.sound_ms += 200
    browser.play(2.0)
    assert abs(browser.skews_ms[-1]) <= 14
    browser.sound_ms -= 200
    browser.play(2.0)
    assert abs(browser.skews_ms[-1]) <= 14


def test_after_an_outage_pictures_are_shown_at_once_and_then_held_again() -> None:
    """A picture that froze for a second ends the hold-back at once, for 6 s."""
    policy = AudioMaster(OBSERVER)
    for tick in range(8):
        held_ms = policy.decide(_told(160, 60), tick / 4).picture_ms
    assert held_ms
    stood = PlayoutReport(StreamPlayout(None), StreamPlayout(age_ms=1250, delay_ms=None))
    assert policy.decide(stood, 4.0).picture_ms == 0.0
    for tick in range(24):
        targets = policy.decide(_told(160, 60), 4.0 + tick / 4)
        assert (targets.picture_ms, "at once" in str(targets.reason)) == (0.0, True)
    assert policy.decide(_told(160, 60), 10.25).picture_ms == 100.0


def test_an_old_picture_that_moves_is_held_back_on() -> None:
    """Moving pictures older than a second, as over a queued satellite link, stay in step."""
    policy = AudioMaster(OBSERVER)
    told = PlayoutReport(StreamPlayout(1400, 160), StreamPlayout(1200, 40))
    assert policy.decide(told, 1.0).picture_ms


def test_one_report_that_is_far_off_moves_nothing() -> None:
    """One outlier, as after a keyframe, changes no hold-back."""
    policy = AudioMaster(OBSERVER)
    for tick in range(12):
        held_ms = policy.decide(_told(160, 100 if tick == 0 else 160), tick / 4).picture_ms
    assert policy.decide(_told(160, 400), 3.0).picture_ms == held_ms
    assert policy.decide(_told(160, 160), 3.25).picture_ms == held_ms


@given(
    st.lists(st.tuples(reports, st.floats(), estimates, allocations), max_size=30),
    st.sampled_from([0, 50, 500]),
    st.sampled_from(["auto", 20.0, 500.0]),
)
def test_the_bounds_hold_whatever_is_reported(
    trace: list[tuple[PlayoutReport, float, LinkEstimate | None, Allocation | None]],
    ceiling: int,
    delay: float | str,
) -> None:
    """No report, estimate or clock, however wrong, exceeds either stream's bounds."""
    sync = {"max_holdback_ms": float(ceiling), "audio_delay_ms": delay}
    policy = AudioMaster(SyncSettings.model_validate(sync))
    for report, now_s, estimate, allocation in trace:
        targets = policy.decide(report, now_s, estimate, allocation)
        assert targets.picture_ms is not None
        assert 0 <= targets.picture_ms <= ceiling
        assert targets.sound_ms is None or 0 <= targets.sound_ms <= 500


@given(st.lists(st.tuples(ages, ages), max_size=30), st.sampled_from(["auto", 20.0, 500.0]))
def test_the_sound_never_waits_for_the_picture(
    trace: list[tuple[float | None, float | None]], delay: float | str
) -> None:
    """However late the picture is, the sound's target is what the sound alone needs."""
    policy = AudioMaster(SyncSettings.model_validate({"audio_delay_ms": delay}))
    expected = None if delay == "auto" else delay
    assert policy.start().sound_ms == expected
    for tick, (sound_ms, picture_ms) in enumerate(trace):
        assert policy.decide(_told(sound_ms, picture_ms), tick / 4).sound_ms == expected


def test_a_set_delay_holds_both_streams_from_the_first_moment() -> None:
    """With a configured delay the picture is held back before any measurement."""
    policy = AudioMaster(SyncSettings(audio_delay_ms=400.0))
    targets = policy.start()
    assert (targets.sound_ms, targets.picture_ms) == (400.0, 400.0)
    assert policy.preroll_ms == 400.0


def test_without_sound_the_picture_waits_for_nothing() -> None:
    """With only video wanted, the picture is shown as soon as possible (thesis 3.3)."""
    policy = AudioMaster(SyncSettings(audio_delay_ms=300.0))
    targets = policy.decide(PlayoutReport(sound=None, picture=StreamPlayout(40, 8)), 1.0)
    assert targets.picture_ms == 0.0


def test_a_browser_that_tells_no_ages_is_followed_by_its_buffers() -> None:
    """Without RTP times the picture follows the sound's measured buffer delay."""
    policy = AudioMaster(OBSERVER)
    delay_ms = 8.0
    for tick in range(12):
        report = PlayoutReport(StreamPlayout(None, 200.0), StreamPlayout(None, delay_ms))
        delay_ms = max(policy.decide(report, tick / 4).picture_ms or 0.0, 8.0)
    assert abs(delay_ms - 200.0) <= 14.0


def test_the_built_in_player_sets_its_delay_by_itself() -> None:
    """Whatever it reports, the built-in player gets no target but a configured delay."""
    estimate = LinkEstimate("steady", 1e6, 1e5, 0.0, 150.0, 0.0, 0, 50.0)
    for delay, asked in (("auto", None), (300.0, 300.0)):
        policy = AudioMaster(SyncSettings.model_validate({"audio_delay_ms": delay}))
        for tick in range(20):
            heard = StreamPlayout(90, 40, 100.0 * tick, 250.0 * tick, 0.0, is_built_in=True)
            report = PlayoutReport(sound=heard, picture=StreamPlayout(40, 8))
            targets = policy.decide(report, tick / 4, estimate)
            assert targets.sound_ms == asked
        assert targets.picture_ms


def test_what_was_learned_of_the_link_outlives_a_change_of_role() -> None:
    """A delay that was found survives a change of policy; a configured one overrides it."""
    policy = AudioMaster(OBSERVER)
    estimate = LinkEstimate("steady", 1e6, 1e5, 0.0, 150.0, 0.0, 0, 50.0)
    assert policy.decide(_told(150, 90), 1.0, estimate).sound_ms == 100.0
    other = make_policy(OPERATOR, policy.state)
    assert (other.start().sound_ms, other.preroll_ms) == (100.0, 100.0)
    first = make_policy(SyncSettings(policy="video-first"), other.state)
    assert (first.start().sound_ms, first.start().picture_ms) == (100.0, 0.0)
    fixed = make_policy(SyncSettings(audio_delay_ms=50.0), first.state)
    assert fixed.start().sound_ms == 50.0
