"""The sound's delay: enough for this link, no more than needed, and steady."""

from __future__ import annotations

import itertools
import math
import random
from dataclasses import dataclass, field
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.examples import examples

from wax.sync.sound_delay import BOUND_MS, SoundDelay

anything = st.floats(allow_nan=True, allow_infinity=True)


@dataclass
class Ear:
    """A model of a browser's buffer: 30 ms on its own, stretched to the target by 75 ms a second.

    Sound is concealed, at least a packet, while the buffer is shorter than the link needs.
    """

    needs_ms: float
    jitter_ms: float = 5.0
    delay: SoundDelay = field(default_factory=lambda: SoundDelay(None))
    buffer_ms: float = 30.0
    concealed_ms: float = 0.0
    played_ms: float = 0.0
    now_s: float = 0.0
    targets: list[float | None] = field(default_factory=list)
    breaks_s: list[float] = field(default_factory=list)

    def listen(self, seconds: float, seed: int = 1) -> None:
        noise = random.Random(seed)
        for _ in range(int(seconds * 4)):
            self.now_s += 0.25
            self.played_ms += 250
            target_ms = max(30.0, self.delay.target_ms or 0.0)
            self.buffer_ms += max(min(target_ms - self.buffer_ms, 18.75), -18.75)
            if self.buffer_ms < self.needs_ms:
                self.concealed_ms += min(max(self.needs_ms - self.buffer_ms, 20.0), 200.0)
                self.breaks_s.append(self.now_s)
            self.targets.append(
                self.delay.decide(
                    jitter_ms=self.jitter_ms * noise.uniform(0.9, 1.1),
                    mu_ms=20,
                    redundancy=0,
                    concealed_ms=self.concealed_ms,
                    played_ms=self.played_ms,
                    now_s=self.now_s,
                )
            )

    @property
    def changes(self) -> int:
        return sum(a != b for a, b in itertools.pairwise(self.targets))

    @property
    def rises(self) -> int:
        return sum((a or 0) < (b or 0) for a, b in itertools.pairwise(self.targets))


def _decide(delay: SoundDelay, now_s: float, **changed: Any) -> float | None:
    told: dict[str, Any] = {"jitter_ms": 3.0, "concealed_ms": 0.0, "played_ms": now_s * 1000}
    return delay.decide(**{"mu_ms": 20, "redundancy": 0, "now_s": now_s} | told | changed)


def test_a_perfect_link_is_left_to_the_browser() -> None:
    """A browser whose sound does not break gets no target, so that it buffers its least."""
    ear = Ear(needs_ms=10.0)
    ear.listen(600)
    assert set(ear.targets) == {None}


@examples(20)
@given(needs_ms=st.floats(0, 450), seed=st.integers(0, 100))
def test_on_a_steady_link_breaks_end_and_become_rare(needs_ms: float, seed: int) -> None:
    """The delay is found within 10 s; later trials cost six short breaks in half an hour."""
    ear = Ear(needs_ms)
    ear.listen(10, seed)
    assert max(target_ms or 30.0 for target_ms in ear.targets) >= needs_ms
    ear.breaks_s.clear()
    ear.targets.clear()
    ear.listen(1800, seed)
    episodes = sum(b - a > 5 for a, b in itertools.pairwise([0.0, *ear.breaks_s]))
    assert episodes <= 6
    assert ear.rises <= 6
    assert ear.changes <= 50
    assert ear.buffer_ms <= max(30.0, needs_ms + 150)


@examples(30)
@example(jitter_ms=64.0, seed=0)  # around what a decoder conceals and the least target
@given(jitter_ms=st.floats(0, 300), seed=st.integers(0, 100))
def test_measured_jitter_is_met_before_anything_breaks(jitter_ms: float, seed: int) -> None:
    """Jitter beyond what a decoder conceals raises the target, which then hardly changes."""

    def late_ms(share: float) -> float:
        return max(share * jitter_ms - 60, 0.0)

    ear = Ear(needs_ms=0.0, jitter_ms=jitter_ms)
    ear.listen(600, seed)
    target_ms = ear.targets[-1] or 20.0
    assert late_ms(0.9) + 10 <= target_ms <= late_ms(1.1) + 20
    assert ear.changes <= 30  # one in 20 s; the worst of thousands of histories had 24


@given(a=st.floats(0, 600), b=st.floats(0, 600), redundancy=st.integers(0, 4))
def test_more_jitter_never_means_less_delay(a: float, b: float, redundancy: int) -> None:
    """The first target grows with the jitter and with the redundancy."""

    def first(jitter_ms: float, redundancy: int) -> float:
        target_ms = SoundDelay(None).decide(
            jitter_ms=jitter_ms,
            mu_ms=60,
            redundancy=redundancy,
            concealed_ms=None,
            played_ms=None,
            now_s=0.0,
        )
        return target_ms or 0.0

    low, high = sorted((a, b))
    assert first(low, redundancy) <= first(high, redundancy)
    assert first(low, redundancy) <= first(low, redundancy + 1)
    assert first(low, redundancy) >= min(redundancy * 60, BOUND_MS)


@pytest.mark.parametrize("needs_ms", [150.0, 450.0])
def test_within_15_s_of_the_last_stall_the_delay_is_down_again(needs_ms: float) -> None:
    """After a single stall nobody hears later than with the browser's own delay."""
    ear = Ear(needs_ms=needs_ms)
    ear.listen(8)
    assert (ear.targets[-1] or 0) >= needs_ms
    ear.needs_ms = 0.0
    ear.listen(15)
    assert ear.targets[-1] is None
    assert ear.buffer_ms <= 40


def test_stalls_that_keep_coming_do_not_keep_the_delay_up() -> None:
    """Only a break right after a fall counts against falling, not the link's next stall."""
    ear = Ear(needs_ms=300.0)
    for _ in range(20):
        ear.needs_ms = 300.0
        ear.listen(6)
        ear.needs_ms = 0.0
        ear.listen(19)
        assert ear.targets[-1] is None


def test_the_sound_that_breaks_at_the_bound_is_told() -> None:
    """When no delay helps, within 15 s the bound is reached and reported as useless."""
    ear = Ear(needs_ms=2000.0)
    ear.listen(15)
    assert ear.targets[-1] == BOUND_MS
    assert ear.delay.is_useless
    ear.delay.restart()
    assert ear.delay.target_ms is None
    assert not ear.delay.is_useless


def test_an_encoding_change_a_new_peer_and_the_first_second_count_for_nothing() -> None:
    """Concealment while the sound or its encoding starts raises no delay."""
    delay = SoundDelay(None)
    assert _decide(delay, 0.25, concealed_ms=250.0) is None
    assert _decide(delay, 0.75, concealed_ms=500.0) is None
    for tick in range(8):
        assert _decide(delay, 2 + tick / 4, concealed_ms=500.0) is None
    assert _decide(delay, 5.0, mu_ms=60, concealed_ms=600.0) is None
    assert _decide(delay, 5.5, mu_ms=60, concealed_ms=900.0) is None
    assert _decide(delay, 7.0, mu_ms=60, concealed_ms=200.0, played_ms=250.0) is None
    assert _decide(delay, 7.5, mu_ms=60, concealed_ms=400.0, played_ms=750.0) is None


def test_a_break_raises_the_delay_at_once() -> None:
    """The report of a break raises the target at once by what was missing."""
    delay = SoundDelay(None)
    for tick in range(8):
        _decide(delay, tick / 4)
    assert _decide(delay, 2.0, concealed_ms=90.0) == 110.0


def test_what_a_decoder_bridges_is_no_break() -> None:
    """Up to 60 ms of concealment in two seconds raises nothing, however often."""
    delay = SoundDelay(None)
    for tick in range(400):
        made_up_ms = 60.0 * (tick // 9)  # every two and a quarter seconds
        assert _decide(delay, tick / 4, concealed_ms=made_up_ms) is None
        assert not delay.is_breaking


def test_what_was_lost_raises_no_delay() -> None:
    """Concealment of lost packets raises no delay."""
    delay = SoundDelay(None)
    for tick in range(240):
        target_ms = _decide(delay, tick / 4, concealed_ms=tick * 12.5, lost=0.05)
        assert target_ms is None


def test_a_queue_is_no_jitter() -> None:
    """On a congested link nothing rises, not even for earlier concealment."""
    delay = SoundDelay(None)
    for tick in range(8):
        _decide(delay, tick / 4)
    for tick in range(8, 16):
        full = {"is_congested": True, "jitter_ms": 400.0, "concealed_ms": tick * 50.0}
        assert _decide(delay, tick / 4, **full) is None
    assert _decide(delay, 4.0, concealed_ms=15 * 50.0) is None
    assert _decide(delay, 4.25, concealed_ms=16 * 50.0) is None


@pytest.mark.parametrize("fixed_ms", [20.0, 400.0])
def test_a_set_delay_stays(fixed_ms: float) -> None:
    """A configured delay stays the target, whatever happens."""
    ear = Ear(needs_ms=2000.0, jitter_ms=300.0, delay=SoundDelay(fixed_ms))
    ear.listen(60)
    assert set(ear.targets) == {fixed_ms}
    assert not ear.delay.is_useless


@pytest.mark.parametrize(
    ("fixed_ms", "output_ms", "buffer_ms"),
    [(200.0, 32.0, 170.0), (500.0, 180.0, 320.0), (100.0, 180.0, 20.0), (200.0, 4.0, 200.0)],
)
def test_what_waits_in_the_device_is_part_of_a_set_delay(
    fixed_ms: float, output_ms: float, buffer_ms: float
) -> None:
    """A configured delay includes the device's delay, such as a headset's."""
    delay = SoundDelay(fixed_ms)
    for tick in range(8):
        assert _decide(delay, tick / 4, output_ms=output_ms) == buffer_ms


def test_a_devices_blocks_are_not_followed_but_another_device_is() -> None:
    """Measurements that vary by a block change nothing; a new headset is noticed within 4 s."""
    delay = SoundDelay(300.0)
    blocks = [_decide(delay, tick / 4, output_ms=30.0 + tick % 2 * 10) for tick in range(40)]
    assert len(set(blocks)) == 1
    for tick in range(40, 56):
        _decide(delay, tick / 4, output_ms=200.0)
    target_ms = delay.target_ms
    assert target_ms is not None
    assert abs(target_ms - 100.0) <= 10
    _decide(delay, 14.0, output_ms=None)
    _decide(delay, 14.25, output_ms=math.nan)
    assert delay.target_ms == target_ms


@given(
    st.lists(
        st.tuples(
            anything,
            st.sampled_from([10, 20, 60, 120]),
            st.integers(0, 5),
            st.none() | anything,
            st.none() | anything,
            anything,
            anything,
            st.integers(-5, 1000),
            st.booleans(),
        ),
        max_size=40,
    ),
    st.floats(20, 500),
)
def test_whatever_is_reported_the_delay_is_bounded(
    reports: list[tuple[float, int, int, float | None, float | None, float, float, int, bool]],
    bound_ms: float,
) -> None:
    """NaN, infinity, and counters and clocks that go back leave the target in its range."""
    delay = SoundDelay(None, bound_ms=bound_ms)
    for jitter_ms, mu_ms, redundancy, concealed_ms, played_ms, now_s, lost, burst, full in reports:
        target_ms = delay.decide(
            jitter_ms=jitter_ms,
            mu_ms=mu_ms,
            redundancy=redundancy,
            concealed_ms=concealed_ms,
            played_ms=played_ms,
            now_s=now_s,
            lost=lost,
            burst=burst,
            is_congested=full,
        )
        assert target_ms is None or (math.isfinite(target_ms) and 0 <= target_ms <= bound_ms)
