"""The extra roll-back for a client that buffers more sound than the reference (thesis 5.3.1)."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.baseline.compensation import Compensation
from wax.config.thesis import ThesisSettings
from wax.sync.playout import PlayoutReport, StreamPlayout

SETTINGS = ThesisSettings()
ROLLBACK_S = 0.5

ages = st.none() | st.floats(-1e15, 1e15)
streams = st.none() | st.builds(StreamPlayout, age_ms=ages, delay_ms=ages)
reports = st.builds(PlayoutReport, sound=streams, picture=streams)


class Client:
    """Shows what the server holds back; a change takes effect a roll-back later."""

    def __init__(self, *, sound_age_ms: float, picture_age_ms: float, ages: bool = True) -> None:
        self._sound_age_ms = sound_age_ms
        self._picture_age_ms = picture_age_ms
        self._ages = ages
        self._extras: list[tuple[float, float]] = [(-1e9, 0.0)]

    def skew_ms(self, now_s: float) -> float:
        seen_s = now_s - ROLLBACK_S - self._extras[-1][1]
        extra_s = next(extra for when_s, extra in reversed(self._extras) if when_s <= seen_s)
        return self._sound_age_ms - self._picture_age_ms - extra_s * 1000

    def report(self, now_s: float) -> PlayoutReport:
        if self._ages:
            shown_ms = self._sound_age_ms - self.skew_ms(now_s)
            return PlayoutReport(
                sound=StreamPlayout(age_ms=self._sound_age_ms),
                picture=StreamPlayout(age_ms=shown_ms),
            )
        return PlayoutReport(
            sound=StreamPlayout(delay_ms=self._sound_age_ms - 250),
            picture=StreamPlayout(delay_ms=0.0),
        )

    def obey(self, extra_s: float, now_s: float) -> None:
        if extra_s != self._extras[-1][1]:
            self._extras.append((now_s, extra_s))


def _run(client: Client, seconds: float) -> Compensation:
    compensation = Compensation(SETTINGS)
    for tick in range(int(seconds * 4)):
        now_s = tick / 4
        rollback_s = ROLLBACK_S + compensation.extra_s
        client.obey(compensation.reported(client.report(now_s), rollback_s, now_s), now_s)
    return compensation


@given(st.floats(300, 1000), st.floats(0, 700))
def test_the_picture_meets_the_sound(sound_age_ms: float, picture_age_ms: float) -> None:
    """Within 10 s the picture is within half a video MU of the sound, if 500 ms suffice."""
    client = Client(sound_age_ms=sound_age_ms, picture_age_ms=picture_age_ms)
    early_ms = client.skew_ms(0.0)
    extra_s = _run(client, 10.0).extra_s
    if 0 <= early_ms <= 500:
        assert abs(client.skew_ms(20.0)) <= 50 + 1e-6
    elif early_ms < 0:
        assert extra_s == 0.0
    else:
        assert extra_s == 0.5


def test_the_client_of_the_thesis_is_compensated_by_its_buffer() -> None:
    """Without ages, a buffer of 256 ms instead of the reference's 50 gives 206 ms more."""
    extra_s = _run(Client(sound_age_ms=756, picture_age_ms=0, ages=False), 10.0).extra_s
    assert abs(extra_s - 0.206) < 1e-9


def test_the_reference_client_gets_nothing() -> None:
    """A buffer of 50 ms, for which the algorithm was made, changes nothing."""
    assert _run(Client(sound_age_ms=550, picture_age_ms=0, ages=False), 10.0).extra_s == 0.0


@given(st.lists(st.tuples(reports, st.floats(0, 10), st.none() | st.floats(0, 2)), max_size=40))
def test_the_bound_holds_whatever_is_reported(
    trace: list[tuple[PlayoutReport, float, float | None]],
) -> None:
    """No report, however wrong, exceeds the bound or gives a negative roll-back."""
    compensation = Compensation(SETTINGS)
    now_s = 0.0
    for report, step_s, rollback_s in trace:
        now_s += step_s
        assert 0.0 <= compensation.reported(report, rollback_s, now_s) <= 0.5


def test_a_single_report_moves_nothing() -> None:
    """One outlier in five is ignored, as is every report while nothing is synchronised."""
    compensation = Compensation(SETTINGS)
    good = PlayoutReport(sound=StreamPlayout(age_ms=500), picture=StreamPlayout(age_ms=490))
    bad = PlayoutReport(sound=StreamPlayout(age_ms=900), picture=StreamPlayout(age_ms=490))
    for tick in range(40):
        report = bad if tick % 5 == 0 else good
        assert compensation.reported(report, ROLLBACK_S, tick / 4) == 0.0
    for tick in range(40, 60):
        assert compensation.reported(bad, None, tick / 4) == 0.0


def test_reports_of_two_kinds_are_not_mixed() -> None:
    """Each measure needs five reports in a row, so alternating ones change nothing."""
    compensation = Compensation(SETTINGS)
    ages = PlayoutReport(sound=StreamPlayout(age_ms=900), picture=StreamPlayout(age_ms=490))
    buffers = PlayoutReport(sound=StreamPlayout(delay_ms=700), picture=StreamPlayout(delay_ms=0))
    for tick in range(40):
        report = ages if tick % 4 else buffers
        assert compensation.reported(report, ROLLBACK_S, tick / 4) == 0.0
    for tick in range(40, 45):
        compensation.reported(ages, ROLLBACK_S, tick / 4)
    assert compensation.extra_s > 0.3
