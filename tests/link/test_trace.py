"""Traces are replayed as in mahimahi, and invalid ones are refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.link.errors import ProfileError
from tests.link.trace import TraceTransmitter, read

if TYPE_CHECKING:
    from pathlib import Path

traces = st.lists(st.integers(0, 200), min_size=1, max_size=20).map(sorted).filter(lambda t: t[-1])


def test_small_packets_share_an_opportunity() -> None:
    """Three packets of 500 bytes leave at one opportunity, the fourth at the next."""
    sender = TraceTransmitter([10, 20], 0.0)
    assert [sender.finish_s(0.0, 500) for _ in range(4)] == [0.01, 0.01, 0.01, 0.02]


def test_a_large_packet_takes_several() -> None:
    """4000 bytes need three opportunities, two of which may be in the same millisecond."""
    assert TraceTransmitter([10, 10, 30], 0.0).finish_s(0.0, 4000) == 0.03


def test_what_nobody_waits_for_is_lost() -> None:
    """An opportunity that passed unused does not help later packets."""
    sender = TraceTransmitter([10, 20, 30], 0.0)
    assert sender.finish_s(0.025, 1500) == 0.03


def test_the_trace_loops() -> None:
    """After its last line it continues from its first, without a pause between."""
    sender = TraceTransmitter([0, 40, 100], 5.0)
    times_s = [sender.finish_s(5.0, 1500) for _ in range(7)]
    assert times_s == pytest.approx([5.0, 5.04, 5.1, 5.1, 5.14, 5.2, 5.2])


@given(traces, st.lists(st.tuples(st.floats(0, 0.3), st.integers(1, 3000)), max_size=40))
def test_nothing_leaves_early_or_faster_than_the_trace(
    times_ms: list[int], packets: list[tuple[float, int]]
) -> None:
    """Departures lie on opportunities, never fall, and no more bytes leave than these carry."""
    sender = TraceTransmitter(times_ms, 0.0)
    now_s = free_s = 0.0
    sent: dict[int, int] = {}
    total = 0
    for gap_s, size_bytes in packets:
        now_s += gap_s
        left_s = sender.finish_s(max(now_s, free_s), size_bytes)
        assert left_s >= max(now_s, free_s) - 1e-9
        free_s = left_s
        at_ms = round(left_s * 1000)
        assert at_ms % times_ms[-1] in {time_ms % times_ms[-1] for time_ms in times_ms}
        total += size_bytes
        sent[at_ms] = total
    for at_ms, bytes_until in sent.items():
        rounds = at_ms // times_ms[-1] + 1
        offered = sum(
            at + turn * times_ms[-1] <= at_ms for turn in range(rounds) for at in times_ms
        )
        assert bytes_until <= offered * 1500


@given(traces)
def test_kept_full_it_sends_its_mean_rate(times_ms: list[int]) -> None:
    """Over whole rounds a full queue sends 1500 bytes an opportunity."""
    sender = TraceTransmitter(times_ms, 0.0)
    for _ in range(5 * len(times_ms)):
        left_s = sender.finish_s(0.0, 1500)
    assert left_s == pytest.approx(5 * times_ms[-1] / 1000)
    assert sender.mean_bps == pytest.approx(5 * len(times_ms) * 12_000 / left_s)


@pytest.mark.parametrize(
    ("text", "said"),
    [("", "longer than 0 ms"), ("0\n0\n", "longer"), ("1\nx\n", "a time in ms"), ("2\n1", "fall")],
)
def test_what_is_no_trace_is_refused(tmp_path: Path, text: str, said: str) -> None:
    """For an empty, wordy or falling file one sentence names the file and the problem."""
    path = tmp_path / "a.trace"
    path.write_text(text)
    with pytest.raises(ProfileError, match=rf"a\.trace: is no trace.*{said}"):
        read(str(path))
