"""Probes prove that messages to a topic arrive, and never stop the robot."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.house.probes import AGAIN_S, LIMIT_S, PERIOD_S, Probes

STOP, OPEN = "rover/stop/set", "rover/open/set"
BEFORE_PROBES_BYTES = 1024
"""The largest packet that an older server, which knows no probes, asked its broker for."""


def _sent(probes: Probes, now_s: float) -> dict[str, bytes]:
    return dict(probes.due(now_s))


def test_a_way_is_open_while_each_probe_comes_back() -> None:
    """A topic is probed at once and then every 30 s, and stays open while a probe is in flight."""
    probes = Probes([STOP, OPEN])
    sent = _sent(probes, 0.0)
    assert list(sent) == [STOP, OPEN]
    assert (probes.is_open(STOP), probes.are_tried(), probes.closed()) == (False, False, [])
    for topic, payload in sent.items():
        assert probes.consume(topic, payload, 0.1)
        assert probes.is_open(topic)
    assert probes.are_tried()
    assert _sent(probes, PERIOD_S - 0.1) == {}
    assert list(_sent(probes, PERIOD_S)) == [STOP, OPEN]
    assert probes.is_open(STOP)


def test_a_lost_probe_closes_its_way_until_one_comes_back() -> None:
    """A lost probe closes its topic alone, which is probed again sooner."""
    probes = Probes([STOP, OPEN])
    sent = _sent(probes, 0.0)
    probes.consume(OPEN, sent[OPEN], 0.1)
    assert _sent(probes, LIMIT_S) == {}
    assert probes.closed() == []
    assert _sent(probes, LIMIT_S + 0.1) == {}
    assert (probes.closed(), probes.are_tried()) == ([STOP], True)
    again = _sent(probes, AGAIN_S)
    assert list(again) == [STOP]
    assert probes.consume(STOP, again[STOP], AGAIN_S + 0.1)
    assert probes.closed() == []


def test_what_comes_late_or_again_proves_nothing() -> None:
    """A probe that returns late, twice or replayed proves nothing."""
    probes = Probes([STOP])
    first = _sent(probes, 0.0)[STOP]
    assert probes.consume(STOP, first, LIMIT_S + 0.1)
    assert probes.closed() == [STOP]
    second = _sent(probes, AGAIN_S)[STOP]
    assert second != first
    assert probes.consume(STOP, first, AGAIN_S)
    assert probes.closed() == [STOP]
    assert probes.consume(STOP, second, AGAIN_S)
    assert probes.consume(STOP, second, AGAIN_S)
    assert probes.is_open(STOP)


def test_another_servers_probe_is_no_stop_and_proves_nothing() -> None:
    """A probe of another server, or by another topic, is no command and proves nothing."""
    probes, other = Probes([STOP, OPEN]), Probes([STOP])
    own = _sent(probes, 0.0)
    assert probes.consume(STOP, _sent(other, 0.0)[STOP], 0.1)
    assert not probes.consume(OPEN, own[STOP], 0.1)
    assert not probes.consume(STOP, own[OPEN], 0.1)
    assert (probes.is_open(STOP), probes.is_open(OPEN)) == (False, False)


def test_servers_that_know_no_probes_get_none_of_stops() -> None:
    """A probe of Stop exceeds the packet size of older servers, which would obey it."""
    assert len(_sent(Probes([STOP]), 0.0)[STOP]) >= BEFORE_PROBES_BYTES


@pytest.mark.parametrize("change", [b"", b"x", b" ", b"wax-probe"])
def test_what_only_looks_like_a_probe_is_a_command(change: bytes) -> None:
    """A Stop with any other content stops the robot."""
    probe = _sent(Probes([STOP]), 0.0)[STOP]
    for payload in (probe.strip(), probe + change + b"x", change + b"x" + probe, probe[:-1]):
        assert not Probes([STOP]).consume(STOP, payload, 0.0)


@given(st.binary(max_size=100) | st.text(max_size=100).map(str.encode))
def test_nobody_means_a_probe(payload: bytes) -> None:
    """No payload that people or automations send is taken for a probe."""
    assert not Probes([STOP]).consume(STOP, payload, 0.0)
