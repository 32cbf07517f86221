"""What becomes of sent packets on links that lose, reorder and delay."""

from __future__ import annotations

from collections import Counter
from copy import deepcopy
from functools import cache
from random import Random
from typing import TYPE_CHECKING, Literal

import pytest
from hypothesis import Phase, example, given
from hypothesis import strategies as st
from tests.examples import examples
from tests.rtc.browser_feedback import feedback_packet

from wax.rtc.in_flight import InFlight
from wax.rtc.twcc_feedback import PERIOD_S, TICK_S, Feedback, parse

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.control import Delivery


def send(transmissions: InFlight, now_s: float, count: int = 1) -> list[int]:
    """Send `count` packets of 100 bytes; the train is how many were sent before, modulo 1000."""
    return [
        transmissions.sent(now_s, size_bytes=100, kind="video", train=index)
        for index in range(count)
    ]


@cache
def _numbered(count: int) -> InFlight:
    transmissions = InFlight()
    send(transmissions, 0.0, count)
    assert transmissions.oldest_unreported_s(100.0) is None
    return transmissions


def numbered(count: int) -> InFlight:
    """Return an `InFlight` that sent `count` packets long ago."""
    return deepcopy(_numbered(count))


def feedback(sequence_number: int, arrivals: Sequence[float | None]) -> Feedback:
    """Return feedback on these packets, None for one that has not arrived."""
    came = [(place, at) for place, at in enumerate(arrivals) if at is not None]
    return Feedback(sequence_number, len(arrivals), came)


def trains(told: tuple[Delivery, ...]) -> list[tuple[int | None, float | None]]:
    return [(one.train, one.arrived_s) for one in told]


def test_an_arrival_comes_with_what_was_sent() -> None:
    """An arrival is returned with the packet's time, size, kind and train."""
    transmissions = InFlight()
    kinds: list[Literal["audio", "video", "repeat"]] = ["audio", "video", "repeat"]
    numbers = [
        transmissions.sent(10 + i, size_bytes=50 + i, kind=kind, train=i if i == 1 else None)
        for i, kind in enumerate(kinds)
    ]
    assert numbers == [0, 1, 2]
    told = transmissions.reported(feedback(0, (5.0, None, 5.25)), 12.5)
    assert [(t.sent_s, t.arrived_s, t.size_bytes, t.kind, t.train) for t in told] == [
        (10, 5.0, 50, "audio", None),
        (11, None, 51, "video", 1),
        (12, 5.25, 52, "repeat", None),
    ]


def test_packets_on_another_path_are_forgotten() -> None:
    """Packets sent on another path are neither awaited nor reported, and numbering continues."""
    transmissions = numbered(3)
    transmissions.reported(feedback(0, (5.0, None, None)), 100.0)
    send(transmissions, 100.0, 2)
    transmissions.forget()
    assert transmissions.oldest_unreported_s(101.0) is None
    assert transmissions.sent(101.0, size_bytes=100, kind="video", train=7) == 5
    assert transmissions.oldest_unreported_s(101.5) == 0.5
    assert trains(transmissions.reported(feedback(0, (None, 6.0, 6.0, 6.0, 6.0, 6.1)), 102.0)) == [
        (7, 6.1)
    ]


def test_packets_are_lost_only_once_a_later_one_has_arrived() -> None:
    """Packets are not reported lost while no later one has arrived."""
    transmissions = InFlight()
    send(transmissions, 0.0, 6)
    told = transmissions.reported(feedback(0, (1.0, None, 1.1, None, None)), 0.2)
    assert trains(told) == [(0, 1.0), (1, None), (2, 1.1)]
    assert transmissions.reported(feedback(3, (None, None)), 0.3) == ()
    told = transmissions.reported(feedback(4, (1.2, 1.3)), 0.4)
    assert trains(told) == [(3, None), (4, 1.2), (5, 1.3)]


def test_an_arrival_may_follow_a_loss() -> None:
    """A reordered packet is reported lost once, then arrived once."""
    transmissions = InFlight()
    send(transmissions, 0.0, 3)
    assert trains(transmissions.reported(feedback(0, (1.0, None, 1.2)), 0.2))[1] == (1, None)
    assert transmissions.reported(feedback(1, (None, 1.2)), 0.3) == ()
    assert trains(transmissions.reported(feedback(1, (1.3, 1.2)), 0.4)) == [(1, 1.3)]
    assert transmissions.reported(feedback(0, (1.0, 1.3, 1.2)), 0.5) == ()


def test_feedback_on_unsent_packets_reports_nothing() -> None:
    """Feedback on numbers not sent yet, or long forgotten, reports nothing."""
    transmissions = InFlight()
    assert transmissions.reported(feedback(0, (1.0, 1.1)), 0.0) == ()
    send(transmissions, 0.0, 2)
    assert transmissions.reported(feedback(2, (1.0,) * 65_535), 0.0) == ()
    told = transmissions.reported(feedback(0xFFF0, (1.0,) * 65_535), 0.0)
    assert trains(told) == [(0, 1.0), (1, 1.0)]
    send(transmissions, 0.1, 1)
    assert transmissions.reported(feedback(2, (9.0,)), 5.2) == ()


def test_packets_without_feedback_are_forgotten() -> None:
    """Without feedback for 5 s nothing is in flight, and nothing is kept."""
    transmissions = InFlight()
    assert transmissions.oldest_unreported_s(0.0) is None
    send(transmissions, 0.0, 3)
    send(transmissions, 1.0, 2)
    assert transmissions.oldest_unreported_s(5.0) == 5.0
    assert transmissions.oldest_unreported_s(5.5) == 4.5
    assert transmissions.oldest_unreported_s(6.5) is None
    assert not transmissions._sent


def test_a_packet_passed_by_a_later_one_is_not_in_flight() -> None:
    """A packet without feedback is not in flight once a later one has arrived."""
    transmissions = InFlight()
    send(transmissions, 0.0, 4)
    send(transmissions, 0.5, 1)
    transmissions.reported(feedback(2, (1.0, None)), 0.6)
    assert transmissions.oldest_unreported_s(0.6) == 0.6
    transmissions.reported(feedback(3, (None, 1.5)), 0.8)
    assert transmissions.oldest_unreported_s(0.8) is None
    assert trains(transmissions.reported(feedback(0, (0.9, 0.95)), 0.9)) == [(0, 0.9), (1, 0.95)]
    assert transmissions.oldest_unreported_s(0.9) is None


def test_numbers_and_clock_are_unwrapped() -> None:
    """Neither the numbers' wrap after 65 536 packets nor the clock's after 12 days shows."""
    transmissions, random = InFlight(), Random(1)
    every_s, before_s = 32.0, 0.0
    for index in range(70_000):
        now_s = 500.0 + index * every_s
        number = transmissions.sent(now_s, size_bytes=80, kind="audio", train=None)
        assert number == index % 2**16
        if index % 500 > 1:
            continue  # the tab slept; at most 4.5 hours
        ticks = round((7.0 + index * every_s) / 250e-6)
        told = transmissions.reported(parse(feedback_packet(number, [ticks], random)), now_s)
        assert len(told) == 1
        assert told[0].arrived_s is not None
        if index:
            assert told[0].arrived_s - before_s == pytest.approx(index * every_s, abs=1e-3)
        else:
            before_s = told[0].arrived_s
    assert index * every_s > 2 * PERIOD_S


def test_memory_is_bounded_by_number_too() -> None:
    """With more packets in flight than numbers can tell apart, the oldest are forgotten."""
    transmissions = InFlight()
    send(transmissions, 0.0, 2**15 + 100)
    assert len(transmissions._sent) <= 2**15


class Browser:
    """Reports as Chromium does: from the first new number, or a late one, to the newest."""

    def __init__(self, arrivals: dict[int, float]) -> None:
        self._coming = sorted((at, number) for number, at in arrivals.items())
        self.known: dict[int, float] = {}
        self.next = 0

    def feedback(self, until_s: float) -> tuple[int, list[float | None]] | None:
        """Return the first number and the arrivals, None if nothing new has arrived."""
        first = self.next
        new = False
        while self._coming and self._coming[0][0] <= until_s:
            at, number = self._coming.pop(0)
            self.known[number] = at
            first = min(first, number)
            self.next = max(self.next, number + 1)
            new = True
        return (first, [self.known.get(n) for n in range(first, self.next)]) if new else None


# A seed cannot be shrunk, so a failure is shown as it was found.
@examples(25, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(
    kind=st.sampled_from(["none", "single", "burst", "all of a second"]),
    jitter_s=st.floats(0, 0.2),
    every_s=st.sampled_from([0.25, 0.1, 0.05]),
    loses_reports=st.booleans(),
    before=st.sampled_from([0, 65_450]),
    seed=st.integers(0, 999),
)
def test_over_any_link_each_packet_is_reported_correctly(
    *, kind: str, jitter_s: float, every_s: float, loses_reports: bool, before: int, seed: int
) -> None:
    """Arrivals are reported once, at the right time, after losses, in the order of sending."""
    random, transmissions = Random(seed), numbered(before)
    plan: dict[int, float | None] = {}
    burst = 0
    for index in range(300):
        burst = burst - 1 if burst else (random.randrange(1, 9) if random.random() < 0.03 else 0)
        lost = {
            "none": False,
            "single": random.random() < 0.1,
            "burst": burst > 0,
            "all of a second": 100 <= index < 150,
        }[kind]
        plan[index] = None if lost else 100 + index * 0.02 + 0.05 + random.random() * jitter_s
    arrivals = {n: at for n, at in plan.items() if at is not None}
    browser = Browser(arrivals)
    lost_before: Counter[int] = Counter()
    arrived: dict[int, float] = {}
    reported: set[int] = set()
    sent = 0
    for step in range(int(8 / every_s)):
        now_s = 100 + step * every_s
        while sent < 300 and 100 + sent * 0.02 <= now_s:
            transmissions.sent(100 + sent * 0.02, size_bytes=100, kind="video", train=sent)
            sent += 1
        found = browser.feedback(now_s)
        if found is None or (loses_reports and random.random() < 0.2):
            continue
        first, seconds = found
        ticks = [None if s is None else round(s / TICK_S) for s in seconds]
        told = transmissions.reported(
            parse(feedback_packet(first + before, ticks, random)), now_s + 0.05
        )
        order = [one.train for one in told if one.train is not None]
        assert len(order) == len(told)
        assert order == sorted(order)
        for one, train in zip(told, order, strict=True):
            assert one.sent_s == pytest.approx(100 + train * 0.02)
            assert train not in arrived
            if one.arrived_s is None:
                assert train < browser.next - 1
                lost_before[train] += 1
            else:
                arrived[train] = one.arrived_s
        reported.update(first + i for i, s in enumerate(seconds) if s is not None)
    assert set(arrived) == reported
    assert all(abs(at - arrivals[n]) <= TICK_S / 2 + 1e-9 for n, at in arrived.items())
    assert all(count == 1 for count in lost_before.values())
    if not loses_reports:
        assert reported == set(arrivals)
        told_lost = {n for n in lost_before if n not in arrived}
        assert told_lost == {n for n in plan if plan[n] is None and n < max(arrivals)}
    assert transmissions.oldest_unreported_s(120) is None
    assert not transmissions._sent
    assert not transmissions._untold


@given(
    st.lists(
        st.tuples(
            st.floats(0, 2),
            st.integers(0, 5),
            st.integers(0, 0xFFFF) | st.integers(0, 30),
            st.lists(st.none() | st.floats(-PERIOD_S, PERIOD_S), min_size=1, max_size=30),
        ),
        max_size=60,
    )
)
def test_no_feedback_corrupts_the_state(
    trace: list[tuple[float, int, int, list[float | None]]],
) -> None:
    """Whatever a page claims, no more is reported than was sent, and nothing old is in flight."""
    transmissions, now_s = InFlight(), 0.0
    sent: list[float] = []
    arrived = lost = 0
    for pause_s, count, number, arrivals in trace:
        now_s += pause_s
        send(transmissions, now_s, count)
        sent += [now_s] * count
        told = transmissions.reported(feedback(number, tuple(arrivals)), now_s)
        arrived += sum(one.arrived_s is not None for one in told)
        lost += sum(one.arrived_s is None for one in told)
        assert arrived <= len(sent)
        assert lost <= len(sent)
        recent = [at for at in sent if now_s - at <= 5]
        oldest_s = transmissions.oldest_unreported_s(now_s)
        assert oldest_s is None or (recent and 0 <= oldest_s <= 5)
        assert set(transmissions._untold) <= set(transmissions._sent)
        assert len(transmissions._sent) <= len(recent)


class Plain:
    """A reference for `InFlight` that visits every packet a feedback spans, and every set."""

    def __init__(self) -> None:
        self.sent: dict[int, float] = {}
        self.next = self._ahead = 0
        self._missing: set[int] = set()
        self._told: set[int] = set()

    def reported(self, number: int, arrivals: list[float | None]) -> list[tuple[int, float | None]]:
        start = self.next + (number - self.next + 0x8000 & 0xFFFF) - 0x8000
        told: list[tuple[int, float | None]] = []
        for place, arrived_s in enumerate(arrivals):
            if start + place not in self.sent:
                continue
            if arrived_s is not None:
                told.append((start + place, arrived_s))
                del self.sent[start + place]
                self._missing.discard(start + place)
                self._ahead = max(self._ahead, start + place + 1)
            elif start + place not in self._told:
                self._missing.add(start + place)
        lost = {number for number in self._missing if number < self._ahead}
        self._missing -= lost
        self._told |= lost
        return sorted([*told, *((number, None) for number in lost)])


REPORTS = st.lists(
    st.tuples(
        st.integers(0, 12),
        st.integers(-60, 3),
        st.lists(st.none() | st.floats(1, 100), max_size=30),
        st.integers(0, 3),
    ),
    max_size=60,
)


@example([(1, -1, [None], 0), (2, -1, [None], 0), (0, -1, [], 0)], 0)
@given(REPORTS, st.sampled_from([0, 65_450]))
def test_it_matches_the_reference(
    trace: list[tuple[int, int, list[float | None], int]], before: int
) -> None:
    """It matches the reference on reordered, repeated, overlapping and false feedback."""
    transmissions, plain = numbered(before), Plain()
    plain.next = before
    now_s = 100.0
    for count, back, arrivals, again in trace:
        now_s += 0.01
        for _ in range(count):
            transmissions.sent(now_s, size_bytes=100, kind="video", train=plain.next)
            plain.sent[plain.next] = now_s
            plain.next += 1
        start = plain.next + back
        # A browser reports up to the newest arrival, and no loss beyond it.
        is_beyond = start + len(arrivals) >= plain.next
        arrived = [*([50.0] * len(arrivals) if is_beyond else arrivals), 50.0]
        for _ in range(1 + again):
            told = transmissions.reported(feedback(start & 0xFFFF, arrived), now_s)
            assert trains(told) == plain.reported(start & 0xFFFF, arrived)


def test_a_late_report_on_a_burst_is_truncated() -> None:
    """Of thousands of packets in one feedback the newest 128 are reported, the others never."""
    transmissions = InFlight()
    send(transmissions, 0.0, 3000)
    told = transmissions.reported(feedback(0, [*([None] * 2900), *([1.0] * 100)]), 0.5)
    assert len(told) == 128
    assert sum(one.arrived_s is not None for one in told) == 100
    assert transmissions.reported(feedback(0, [None] * 3000), 0.6) == ()
    assert transmissions.oldest_unreported_s(0.6) is None
