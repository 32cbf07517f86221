"""The thesis's sender over a modelled link: in step, newest, one at a time, and never drifting."""

from __future__ import annotations

import heapq
import itertools
from dataclasses import dataclass, field

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.examples import examples

from wax.baseline.media_units import MediaUnit, Stream
from wax.baseline.unit_sender import Decision, UnitSender
from wax.config.thesis import ThesisSettings

A = 0.5
V = 0.1


@dataclass
class Sent:
    """One MU in flight, and the sender's state when it was sent."""

    mu: MediaUnit
    left_s: float
    mode: str
    rollback_s: float | None
    arrived_s: float | None = None
    acknowledged_s: float | None = None
    lost_s: float | None = None

    @property
    def done_s(self) -> float | None:
        """Return when the next might be sent; an acknowledgement after giving up is ignored."""
        return self.acknowledged_s if self.lost_s is None else self.lost_s


@dataclass
class Link:
    """A first-in first-out bottleneck: bytes a second from each moment on, and a one-way delay."""

    rates: list[tuple[float, float]]
    delay_s: float = 0.01
    free_s: float = 0.0
    deaf: frozenset[tuple[Stream, int]] = frozenset()

    def arrival_s(self, size: int, now_s: float) -> float:
        start_s = max(now_s, self.free_s)
        left = float(size)
        for (_, rate), (until_s, _) in itertools.pairwise([*self.rates, (float("inf"), 0.0)]):
            if start_s >= until_s:
                continue
            if rate * (until_s - start_s) >= left:
                self.free_s = start_s + left / rate
                return self.free_s + self.delay_s
            left -= rate * (until_s - start_s)
            start_s = until_s
        raise AssertionError("the last rate must not be 0")


@dataclass
class Run:
    """One sender with capture, link, page and timer, for a limited time."""

    link: Link
    settings: ThesisSettings = field(default_factory=ThesisSettings)
    phase_s: float = 0.0
    sound_until_s: float = float("inf")
    extra_s: float = 0.0
    first_sound_late_s: float = 0.0
    sent: list[Sent] = field(default_factory=list)
    skipped: list[MediaUnit] = field(default_factory=list)
    modes: list[tuple[float, str]] = field(default_factory=list)
    most_held: int = 0
    batches: list[tuple[Stream, ...]] = field(default_factory=list)

    def go(self, seconds: float, *, sound: bool = True, picture: bool = True) -> Run:
        self.sender = UnitSender(self.settings, sound=sound, picture=picture)
        self._queue: list[tuple[float, int, str, MediaUnit | None]] = []
        self._order = itertools.count()
        self._captured = 0
        self.sender.roll_back_further(self.extra_s, 0.0)
        self._at(0.0, "tick")
        self._at(0.0, "round trip")
        audio_s, video_s = self.settings.audio_mu_ms / 1000, self.settings.video_mu_ms / 1000
        for number in range(int(seconds / audio_s)):
            mu = MediaUnit("sound", number, number * audio_s, audio_s)
            if mu.ready_s <= self.sound_until_s:
                late_s = self.first_sound_late_s if number == 0 else 0.0
                self._at(mu.ready_s + late_s, "captured", mu)
        for number in range(int(seconds / video_s)):
            mu = MediaUnit("picture", number, number * video_s + self.phase_s, video_s)
            self._at(mu.ready_s, "captured", mu)
        self._step_until(seconds)
        return self

    def of(self, stream: Stream) -> list[Sent]:
        return [one for one in self.sent if one.mu.stream == stream]

    def _at(self, when_s: float, what: str, mu: MediaUnit | None = None) -> None:
        heapq.heappush(self._queue, (when_s, next(self._order), what, mu))

    def _step_until(self, end_s: float) -> None:
        self._wake_s = 0.0
        while self._queue and self._queue[0][0] <= end_s:
            now_s, _, what, mu = heapq.heappop(self._queue)
            if what == "tick" and now_s != self._wake_s:
                continue  # a newer decision has rescheduled it
            if what == "captured" and mu is not None:
                self._captured += 1
                decision = self.sender.captured(mu, now_s)
            elif what == "acknowledged" and mu is not None:
                self._find(mu).acknowledged_s = now_s
                decision = self.sender.acknowledged(mu.stream, mu.number, now_s)
            elif what == "round trip":
                decision = self.sender.round_trip(2 * self.link.delay_s, now_s)
            else:
                decision = self.sender.tick(now_s)
            self._obey(decision, now_s)
            self._wake_s = max(decision.wake_s, now_s)
            self._at(self._wake_s, "tick")

    def _obey(self, decision: Decision, now_s: float) -> None:
        self.skipped += decision.skipped
        for mu in decision.lost:
            self._find(mu).lost_s = now_s
        state = self.sender.state()
        self.batches.append(tuple(mu.stream for mu in decision.send))
        for mu in decision.send:
            size = self.settings.audio_mu_ms * 8 if mu.stream == "sound" else 8000
            one = Sent(mu, now_s, state.mode, state.rollback_s)
            self.sent.append(one)
            one.arrived_s = self.link.arrival_s(size, now_s)
            if (mu.stream, mu.number) not in self.link.deaf:
                self._at(one.arrived_s + self.link.delay_s, "acknowledged", mu)
        if not self.modes or self.modes[-1][1] != state.mode:
            self.modes.append((now_s, state.mode))
        self.most_held = max(self.most_held, self._captured - len(self.sent) - len(self.skipped))

    def _find(self, mu: MediaUnit) -> Sent:
        return next(one for one in reversed(self.sent) if one.mu == mu)


def _constant(rate: float, delay_s: float = 0.01) -> Link:
    return Link(rates=[(0.0, rate)], delay_s=delay_s)


# A modem's 2 kB/s to 2 MB/s, with outages, and pieces from a blink to many seconds.
rates = st.lists(
    st.tuples(st.floats(0.05, 8.0), st.sampled_from([0.0, 2e3, 7e3, 2e4, 4e4, 1e5, 3e5, 2e6])),
    min_size=0,
    max_size=6,
)


@st.composite
def links(draw: st.DrawFn) -> Link:
    pieces, start_s = [(0.0, draw(st.sampled_from([4e3, 3e4, 2e6])))], 0.0
    for length_s, rate in draw(rates):
        start_s += length_s
        pieces.append((start_s, rate))
    if pieces[-1][1] == 0.0:
        pieces.append((start_s + 3.0, 5e4))
    return Link(rates=pieces, delay_s=draw(st.floats(0.0, 0.4)))


audio_mus = st.sampled_from([100, 200, 300, 400, 500])


def _run(link: Link, audio_mu_ms: int, phase_s: float) -> Run:
    return Run(link, ThesisSettings(audio_mu_ms=audio_mu_ms), phase_s).go(12.0)


# --- what holds on every link ----------------------------------------------------------------


@examples(200)
@given(links(), audio_mus, st.floats(0, 0.09))
def test_nothing_newer_leaves_before_the_acknowledgement(
    link: Link, audio_mu_ms: int, phase_s: float
) -> None:
    """Of each stream the next MU is sent when the last is acknowledged or lost."""
    run = _run(link, audio_mu_ms, phase_s)
    for stream in ("sound", "picture"):
        for one, after in itertools.pairwise(run.of(stream)):
            assert after.mu.number > one.mu.number
            assert one.done_s is not None
            assert one.done_s <= after.left_s


# An outage in which a picture counts as lost, but is acknowledged later.
@example(Link([(0.0, 4e3), (1.0625, 1e5), (3.0625, 0.0), (6.0625, 5e4)], delay_s=0.0), 500, 0.0)
@examples(200)
@given(links(), audio_mus, st.floats(0, 0.09))
def test_the_picture_never_drifts(link: Link, audio_mu_ms: int, phase_s: float) -> None:
    """However long a link is slow, lateness never adds up.

    Due is what the virtual clock shows; without one, when it was captured. A picture leaves after
    that by at most as long as the *one* before it was under way, which is at most a second where
    the streams are synchronised, and one video MU.
    """
    run = _run(link, audio_mu_ms, phase_s)
    under_way_s = 0.0
    for one in run.of("picture"):
        late_s = one.left_s - one.mu.ready_s
        if one.mode == "synchronised" and one.rollback_s is not None:
            late_s = one.left_s - one.mu.captured_s - one.rollback_s
            assert under_way_s <= 1.0 + 1e-9
            assert late_s <= under_way_s + V + 1e-9
        else:
            assert late_s <= V + 1e-9
        if one.done_s is not None:
            under_way_s = one.done_s - one.left_s


@examples(200)
@given(links(), audio_mus, st.floats(0, 0.09))
def test_what_is_sent_is_the_newest_allowed(link: Link, audio_mu_ms: int, phase_s: float) -> None:
    """No sound is sent if a newer one is ready; no picture if a newer one was due."""
    run = _run(link, audio_mu_ms, phase_s)
    gone = {(mu.stream, mu.number) for mu in run.skipped}
    for one in run.sent:
        newer = MediaUnit(
            one.mu.stream,
            one.mu.number + 1,
            one.mu.captured_s + one.mu.duration_s,
            one.mu.duration_s,
        )
        if one.mu.stream == "picture" and one.mode == "synchronised":
            assert one.rollback_s is not None
            # A skipped picture had no place in the cache, which is the algorithm's own limit.
            is_due = newer.captured_s + one.rollback_s < one.left_s
            assert not is_due or ("picture", newer.number) in gone
        else:
            assert newer.ready_s >= one.left_s - 1e-9


@examples(200)
@given(links(), audio_mus, st.floats(0, 0.09))
def test_memory_is_bounded_and_nothing_vanishes(
    link: Link, audio_mu_ms: int, phase_s: float
) -> None:
    """At most two audio MUs' worth of pictures and one sound wait, whatever the link does.

    All captured is sent or skipped, once.
    """
    run = _run(link, audio_mu_ms, phase_s)
    assert run.most_held <= 2 * audio_mu_ms // 100 + 2
    done = [(mu.stream, mu.number) for mu in [*run.skipped, *(one.mu for one in run.sent)]]
    assert len(done) == len(set(done))


@examples(200)
@given(links(), audio_mus)
def test_the_sound_goes_first(link: Link, audio_mu_ms: int) -> None:
    """If both may be sent the sound is first, and a picture never delays it."""
    run = _run(link, audio_mu_ms, 0.0)
    assert set(run.batches) <= {(), ("sound",), ("picture",), ("sound", "picture")}
    under_way_until_s = 0.0
    for one in run.of("sound"):
        assert one.left_s <= max(one.mu.ready_s, under_way_until_s) + 1e-9
        under_way_until_s = float("inf") if one.done_s is None else one.done_s


# --- the thesis's cases ----------------------------------------------------------------------


@pytest.mark.parametrize("audio_mu_ms", [200, 300, 400, 500])
def test_a_fast_link_gets_every_picture_in_step_with_the_sound(audio_mu_ms: int) -> None:
    """After start-up all ten pictures a second leave as their sound is heard (5.3.1)."""
    run = Run(_constant(2e6), ThesisSettings(audio_mu_ms=audio_mu_ms)).go(20.0)
    assert [mode for _, mode in run.modes] == ["start-up", "synchronised"]
    synchronised = [one for one in run.of("picture") if one.mode == "synchronised"]
    numbers = [one.mu.number for one in synchronised]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len(numbers) > 180
    for one in synchronised:
        assert one.left_s == pytest.approx(one.mu.captured_s + audio_mu_ms / 1000, abs=1e-6)
    assert run.sender.state().pictures_cached == audio_mu_ms // 100 - 1


def test_start_up_sends_a_picture_first_and_waits_afterwards() -> None:
    """V_2 leaves with A_1; the next picture T_p and one video MU later (3.3.3.2)."""
    run = Run(_constant(2e6)).go(3.0)
    first_sound = run.of("sound")[0]
    with_it = next(one for one in run.of("picture") if one.left_s >= first_sound.left_s)
    after = run.of("picture")[run.of("picture").index(with_it) + 1]
    hold_back_s = run.sender.state().hold_back_s
    assert with_it.left_s == first_sound.left_s
    assert hold_back_s == pytest.approx(with_it.mu.captured_s - first_sound.mu.captured_s)
    assert hold_back_s == pytest.approx(0.4)
    assert after.mu.number == with_it.mu.number + 1
    assert after.left_s == pytest.approx(with_it.left_s + 0.4 + V)


def test_a_slow_link_gets_fewer_pictures_at_its_own_pace() -> None:
    """T_r of 200 ms: at most one cached, one sent as the last has arrived, in time (3.3.4)."""
    run = Run(_constant(40_000.0)).go(30.0)
    assert run.sender.mode == "synchronised"
    assert run.sender.state().pictures_cached in (0, 1)
    late = [one for one in run.of("picture") if one.left_s > 10.0]
    assert len(late) == pytest.approx(20 * (40_000 - 8000) / 8000, rel=0.1)
    for one in late:
        assert one.arrived_s is not None
        # Sound occupies the link for 100 ms, so T_r alternates between 200 and 300 ms.
        assert 0.2 <= one.arrived_s - one.mu.ready_s <= A + 2 * 0.1


def test_a_modem_is_served_in_fail_safe_mode_without_drift() -> None:
    """At 5.9 kB/s (5.4.3) a picture comes every 1.5 to 4 s, fresh when it leaves, for minutes."""
    run = Run(_constant(5900.0, delay_s=0.06)).go(300.0)
    assert run.sender.mode == "fail-safe"
    late = [one for one in run.of("picture") if one.left_s > 10.0]
    gaps_s = [after.left_s - one.left_s for one, after in itertools.pairwise(late)]
    assert 1.5 <= sum(gaps_s) / len(gaps_s) <= 4.0
    assert all(one.left_s - one.mu.ready_s <= V for one in late)
    assert run.sender.state().pictures_cached == 0


def test_fail_safe_is_entered_when_the_link_falls_and_left_when_it_recovers() -> None:
    """5 Mbit/s, then 48 kbit/s for 10 s, then 5 Mbit/s: in step again, after a start-up."""
    run = Run(Link(rates=[(0.0, 6e5), (10.0, 6e3), (20.0, 6e5)], delay_s=0.02)).go(40.0)
    modes = [mode for _, mode in run.modes]
    assert modes[:3] == ["start-up", "synchronised", "fail-safe"]
    assert modes[-2:] == ["start-up", "synchronised"]
    entered_s = next(when_s for when_s, mode in run.modes if mode == "fail-safe")
    left_s = run.modes[-2][0]
    assert 10.0 < entered_s < 12.0
    assert 20.0 < left_s < 26.0
    assert run.of("picture")[-1].left_s - run.of("picture")[-1].mu.captured_s == pytest.approx(A)


def test_an_outage_leaves_nothing_old_behind() -> None:
    """Units sent after an outage of 8 s are fresh, not cached before it."""
    run = Run(Link(rates=[(0.0, 6e5), (5.0, 0.0), (13.0, 6e5)], delay_s=0.02)).go(20.0)
    after = [one for one in run.of("picture") if one.left_s > 6.0]
    assert after
    assert all(one.left_s - one.mu.ready_s <= A + V for one in after)


def test_one_late_picture_costs_no_more_than_itself() -> None:
    """A spike of 200 ms, as on the campus (5.2.1.1), changes neither mode nor cache."""
    run = Run(Link(rates=[(0.0, 6e5), (10.0, 0.0), (10.2, 6e5)], delay_s=0.005)).go(20.0)
    assert [mode for _, mode in run.modes] == ["start-up", "synchronised"]
    late = [one for one in run.of("picture") if one.mode == "synchronised"]
    skipped = late[-1].mu.number - late[0].mu.number + 1 - len(late)
    assert 1 <= skipped <= 2


@pytest.mark.parametrize(("sound", "picture"), [(True, False), (False, True)])
def test_one_stream_alone_goes_as_soon_as_possible(sound: bool, picture: bool) -> None:
    """Only video or only audio asked for: nothing is held back (3.3)."""
    run = Run(_constant(2e6), phase_s=0.05).go(10.0, sound=sound, picture=picture)
    assert run.sent
    assert {one.mu.stream for one in run.sent} == {"sound" if sound else "picture"}
    assert all(one.left_s == pytest.approx(one.mu.ready_s) for one in run.sent)
    assert run.sender.mode == "one stream"
    assert run.sender.state().rollback_s is None


def test_sound_switched_on_begins_with_start_up() -> None:
    """The streams chosen anew are aligned anew, and given up at once when sound goes."""
    sender = UnitSender(ThesisSettings(), sound=False)
    picture = MediaUnit("picture", 0, 0.9, V)
    assert sender.captured(picture, 1.0).send == (picture,)
    sender.acknowledged("picture", 0, 1.01)
    sender.choose(sound=True, picture=True, now_s=1.1)
    assert sender.state().mode == "start-up"
    sound = MediaUnit("sound", 0, 1.0, A)
    assert sender.captured(sound, 1.5).send == (sound,)
    assert sender.state().rollback_s == pytest.approx(0.5)
    sender.choose(sound=False, picture=True, now_s=1.6)
    assert sender.state().mode == "one stream"
    assert sender.state().rollback_s is None


def test_sound_that_stops_at_its_source_holds_no_picture_back() -> None:
    """Two MU lengths after the last sound, pictures are sent as soon as possible."""
    run = Run(_constant(2e6), sound_until_s=5.0).go(12.0)
    late = [one for one in run.of("picture") if one.left_s > 6.2]
    assert len(late) > 50
    assert all(one.left_s == pytest.approx(one.mu.ready_s) for one in late)


def test_the_picture_is_rolled_back_further_for_a_longer_audio_buffer() -> None:
    """206 ms more, as for Java 2 (5.3.1), and still every picture."""
    run = Run(_constant(2e6), extra_s=0.206).go(10.0)
    synchronised = [one for one in run.of("picture") if one.mode == "synchronised"]
    assert len(synchronised) > 80
    for one, after in itertools.pairwise(synchronised):
        assert after.mu.number == one.mu.number + 1
        assert after.left_s == pytest.approx(after.mu.captured_s + A + 0.206)


@pytest.mark.parametrize("waited_s", [0.05, 0.25, 0.45])
def test_sound_that_had_waited_when_the_client_came_rolls_the_picture_back_as_far(
    waited_s: float,
) -> None:
    """The MU "currently in the buffer" is heard that much later, and every picture with it."""
    run = Run(_constant(2e6), first_sound_late_s=waited_s).go(10.0)
    synchronised = [one for one in run.of("picture") if one.mode == "synchronised"]
    assert len(synchronised) > 80
    for one, after in itertools.pairwise(synchronised):
        assert after.mu.number == one.mu.number + 1
        assert after.left_s == pytest.approx(after.mu.captured_s + A + waited_s)


def test_a_number_that_does_not_rise_is_refused() -> None:
    """An MU that is not newer than the last of its stream raises."""
    sender = UnitSender(ThesisSettings())
    sender.captured(MediaUnit("picture", 5, 0.0, V), 0.1)
    with pytest.raises(ValueError, match="not newer"):
        sender.captured(MediaUnit("picture", 5, 0.1, V), 0.2)


def test_a_picture_that_is_never_acknowledged_stops_nothing_for_good() -> None:
    """It is reported as lost, pictures continue, and the sound was never delayed."""
    link = _constant(2e6)
    link.deaf = frozenset({("picture", 60)})
    run = Run(link).go(20.0)
    assert [one.mu.number for one in run.sent if one.lost_s is not None] == [60]
    assert run.of("picture")[-1].left_s > 19.5
    assert len(run.of("sound")) >= 39
