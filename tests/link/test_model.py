"""The model of one direction keeps its promises for any packets at any times."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.link.model import Direction
from tests.link.profile import DirectionSettings

if TYPE_CHECKING:
    from pathlib import Path

START_S = 1000.0

arrivals = st.lists(st.tuples(st.floats(0, 0.2), st.integers(20, 1500)), min_size=1, max_size=60)
"""Gaps before packets in seconds, and their sizes."""


def settings(**keys: Any) -> DirectionSettings:
    queue = {} if {"queue_ms", "queue_bytes"} & keys.keys() else {"queue_bytes": 10**9}
    return DirectionSettings.model_validate({**queue, **keys})


def direction(**keys: Any) -> Direction:
    return Direction(settings(**keys), seed=1, way="down", start_s=START_S)


def number(index: int, size_bytes: int) -> bytes:
    return index.to_bytes(4, "big") + bytes(size_bytes - 4)


def through(
    link: Direction, packets: list[tuple[float, int]], start_s: float = START_S
) -> dict[int, tuple[float, float]]:
    """Send packets (gap, size); return when each that arrived was sent and was due."""
    now_s, sent_s, came = start_s, [], {}
    for index, (gap_s, size_bytes) in enumerate(packets):
        now_s += gap_s
        sent_s.append(now_s)
        link.arrive(number(index, size_bytes), now_s)
    for due_s, packet in link.due(math.inf):
        index = int.from_bytes(packet[:4], "big")
        assert len(packet) == packets[index][1]
        came[index] = (sent_s[index], due_s)
    return came


def regular(count: int, gap_s: float, size_bytes: int = 100) -> list[tuple[float, int]]:
    return [(gap_s, size_bytes)] * count


@given(arrivals)
def test_delay_is_exact(packets: list[tuple[float, int]]) -> None:
    """Without rate and jitter every packet arrives after the delay, to the microsecond."""
    for sent_s, due_s in through(direction(delay_ms=20), packets).values():
        assert due_s - sent_s == pytest.approx(0.020, abs=1e-6)


@given(arrivals, st.integers(10_000, 10_000_000))
def test_serialisation_is_exact_to_the_byte(
    packets: list[tuple[float, int]], rate_bps: int
) -> None:
    """A packet leaves once all bytes up to its own have left at the rate, and not earlier."""
    came = through(direction(rate_bps=rate_bps, delay_ms=5), packets)
    free_s = 0.0
    for index, (_, size_bytes) in enumerate(packets):
        sent_s, due_s = came[index]
        free_s = max(free_s, sent_s) + size_bytes * 8 / rate_bps
        assert due_s == pytest.approx(free_s + 0.005, abs=1e-6)


JITTERS = [
    {"distribution": "uniform", "ms": 50},
    {"distribution": "normal", "ms": 16},
    {"distribution": "pareto", "ms": 30, "shape": 2, "at_most_ms": 500},
]


@pytest.mark.parametrize("jitter", JITTERS)
@given(packets=arrivals)
def test_order_is_kept_under_jitter(
    jitter: dict[str, Any], packets: list[tuple[float, int]]
) -> None:
    """Whatever jitter and stalls do, packets arrive in the order in which they were sent."""
    stalls = {"every_s": 0.2, "at_least_ms": 10, "at_most_ms": 300}
    came = through(direction(delay_ms=50, jitter=jitter, stalls=stalls), packets)
    assert list(came) == sorted(came)
    assert len(came) == len(packets)
    assert all(due_s >= sent_s for sent_s, due_s in came.values())


def test_reorder_lets_packets_overtake() -> None:
    """With `reorder` a packet with less jitter arrives before an earlier one."""
    came = through(direction(delay_ms=50, jitter=JITTERS[0], reorder=True), regular(200, 0.001))
    assert list(came) != sorted(came)
    assert len(came) == 200


@given(arrivals, st.integers(1500, 20_000))
def test_the_queue_never_exceeds_its_bytes(
    packets: list[tuple[float, int]], queue_bytes: int
) -> None:
    """No more than the limit ever waits, and a refused packet would have exceeded it."""
    link = direction(rate_bps=64_000, queue_bytes=queue_bytes)
    came = through(link, packets)
    waiting: list[tuple[float, int]] = []
    now_s = START_S
    for index, (gap_s, size_bytes) in enumerate(packets):
        now_s += gap_s
        inside = sum(size for due_s, size in waiting if due_s > now_s)
        if index in came:
            assert inside + size_bytes <= queue_bytes
            waiting.append((came[index][1], size_bytes))
        else:
            assert inside + size_bytes > queue_bytes
    count = link.counters
    assert count.queue_drops == len(packets) - len(came)
    assert count.backlog_peak_bytes <= queue_bytes


def test_a_queue_in_ms_is_of_the_rate() -> None:
    """At 64 kbit/s, 500 ms hold 4000 bytes: a burst of 20 packets of 400 leaves 10."""
    link = direction(rate_bps=64_000, queue_ms=500)
    assert len(through(link, regular(20, 0.0, 400))) == 10
    assert link.counters.queue_drop_bytes == 10 * 400


def test_a_packet_larger_than_the_queue_passes_alone() -> None:
    """A packet that finds the queue empty is never refused, as in any real device."""
    assert len(through(direction(rate_bps=64_000, queue_bytes=100), [(0, 1500), (0, 1500)])) == 1


@given(arrivals, st.floats(0, 1), st.booleans())
def test_every_packet_is_counted_once(
    packets: list[tuple[float, int]], chance: float, full: bool
) -> None:
    """Each packet and byte that entered has left, was lost, was refused or is inside."""
    queue_bytes = 2000 if full else 10**6
    link = direction(rate_bps=100_000, queue_bytes=queue_bytes, loss={"in_good": chance})
    now_s, out = START_S, []
    for index, (gap_s, size_bytes) in enumerate(packets):
        now_s += gap_s
        link.arrive(number(index, size_bytes), now_s)
        out += link.due(now_s)
    inside = link.counters.packets_in - link.counters.packets_out
    inside -= link.counters.losses + link.counters.queue_drops
    assert inside >= 0
    rest = link.due(math.inf)
    count = link.counters
    assert len(rest) == inside
    assert count.packets_out == len(out) + len(rest)
    assert count.packets_in == len(packets) == count.packets_out + count.losses + count.queue_drops
    assert count.bytes_in == sum(size for _, size in packets)
    assert count.bytes_in == count.bytes_out + count.loss_bytes + count.queue_drop_bytes


def test_nothing_comes_before_it_is_due() -> None:
    """`next_s` says when `due` returns the next packet, and before that it returns none."""
    link = direction(delay_ms=20)
    assert link.next_s() == math.inf
    link.arrive(number(0, 100), START_S)
    assert link.next_s() == pytest.approx(START_S + 0.020)
    assert link.due(link.next_s() - 1e-6) == []
    assert [packet for _, packet in link.due(link.next_s())] == [number(0, 100)]


STEP = [{"at_s": 1, "rate_bps": 300_000}, {"at_s": 2, "rate_bps": 5_000_000}]


def test_changes_come_at_their_time_after_the_start() -> None:
    """Nothing changes before `start_changes`; then the rate steps down and up on time."""
    link = direction(rate_bps=5_000_000, changes=STEP)

    def serialisation_s(at_s: float) -> float:
        link.arrive(number(0, 1500), at_s)
        return link.due(math.inf)[0][0] - at_s

    assert serialisation_s(START_S + 1.5) == pytest.approx(12_000 / 5e6)
    link.start_changes(START_S + 10)
    assert serialisation_s(START_S + 10.5) == pytest.approx(12_000 / 5e6)
    assert serialisation_s(START_S + 11.5) == pytest.approx(12_000 / 300e3)
    assert serialisation_s(START_S + 12.5) == pytest.approx(12_000 / 5e6)


def test_a_change_meets_a_packet_on_the_wire() -> None:
    """Bits sent before a change leave at the old rate, the others at the new one."""
    link = direction(rate_bps=10_000, changes=[{"at_s": 1, "rate_bps": 1_000}])
    link.start_changes(START_S)
    link.arrive(number(0, 1500), START_S)  # 12000 bits: 10000 in the first second
    assert link.next_s() == pytest.approx(START_S + 3)


def test_an_outage_holds_and_then_lets_go() -> None:
    """Packets during an outage wait in the queue and leave at the rate once it is over."""
    changes = [{"at_s": 1, "outage": True}, {"at_s": 3, "outage": False}]
    link = direction(rate_bps=1_000_000, queue_ms=500, changes=changes)
    link.start_changes(START_S)
    came = through(link, regular(50, 0.0, 1250), START_S + 1.5)
    assert [due_s for _, due_s in came.values()] == [
        pytest.approx(START_S + 3 + 0.010 * (index + 1)) for index in range(50)
    ]
    assert len(through(link, regular(60, 0.0, 1250), START_S + 5)) == 50


@given(
    st.lists(
        st.tuples(st.floats(0.1, 2), st.integers(10_000, 1_000_000) | st.none()),
        min_size=1,
        max_size=6,
    )
)
def test_bits_are_conserved_over_any_schedule(spans: list[tuple[float, int | None]]) -> None:
    """A full link delivers by any time exactly what its rates allow until then."""
    changes: list[dict[str, Any]] = []
    at_s = 0.0
    for span_s, span_bps in spans:
        at_s += span_s
        state = {"outage": True} if span_bps is None else {"outage": False, "rate_bps": span_bps}
        changes.append({"at_s": at_s, **state})
    changes.append({"at_s": at_s + 0.5, "outage": False, "rate_bps": 200_000})
    link = direction(rate_bps=100_000, changes=changes)
    link.start_changes(START_S)
    came = through(link, regular(200, 0.0, 1000))
    edges = [0.0, *(change["at_s"] for change in changes), math.inf]
    rates = [100_000, *(0 if c["outage"] else c["rate_bps"] for c in changes)]
    for index, (_, due_s) in came.items():
        bits = 0.0
        for rate_bps, (begin_s, end_s) in zip(rates, pairwise(edges), strict=True):
            bits += rate_bps * max(0.0, min(due_s - START_S, end_s) - begin_s)
        assert bits == pytest.approx((index + 1) * 8000, rel=1e-6)


def test_one_seed_is_one_run() -> None:
    """The same seed repeats every delay and loss; another direction or seed has others."""
    keys: dict[str, Any] = {"delay_ms": 50, "jitter": JITTERS[0], "loss": {"in_good": 0.2}}
    runs = [
        through(Direction(settings(**keys), seed=seed, way=way, start_s=START_S), regular(200, 0.1))
        for seed, way in ((1, "down"), (1, "down"), (1, "up"), (2, "down"))
    ]
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]
    assert runs[0] != runs[3]


def test_losses_do_not_depend_on_jitter() -> None:
    """Which packets are lost is the same with and without jitter, so that two runs compare."""
    loss = {"in_good": 0.1}
    plain = through(direction(delay_ms=50, loss=loss), regular(500, 0.01))
    shaken = through(direction(delay_ms=50, loss=loss, jitter=JITTERS[1]), regular(500, 0.01))
    assert plain.keys() == shaken.keys()


def test_a_trace_is_replayed(tmp_path: Path) -> None:
    """With a trace, packets leave at its times, and again from its start when it is started."""
    path = tmp_path / "a.trace"
    path.write_text("10\n100\n")
    link = direction(trace=str(path), queue_ms=1000, delay_ms=5)
    came = through(link, regular(3, 0.0, 1500))
    assert [due_s - START_S for _, due_s in came.values()] == pytest.approx([0.015, 0.105, 0.115])
    link.start_changes(START_S + 7.05)
    came = through(link, regular(2, 0.0, 1500), START_S + 7.07)
    assert [due_s - START_S for _, due_s in came.values()] == pytest.approx([7.155, 7.165])
