"""What proves that a message to a topic arrives, and what is no Stop for it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.house.probes import AGAIN_S, LIMIT_S, PERIOD_S, Probes

STOP, OPEN = "rover/stop/set", "rover/open/set"
BEFORE_PROBES_BYTES = 1024
"""What a server that knows no probes asked its broker for at most, with all that is around it."""


def _sent(probes: Probes, now_s: float) -> dict[str, bytes]:
    return dict(probes.due(now_s))


def test_a_way_is_open_while_each_probe_comes_back() -> None:
    """It is tried at once and then each half minute, and stays open while one is under way."""
    probes = Probes([STOP, OPEN])
    sent = _sent(probes, 0.0)
    assert list(sent) == [STOP, OPEN]
    assert (probes.is_open(STOP), probes.are_tried(), probes.closed()) == (False, False, [])
    for topic, payload in sent.items():
        assert probes.take(topic, payload, 0.1)
        assert probes.is_open(topic)
    assert probes.are_tried()
    assert _sent(probes, PERIOD_S - 0.1) == {}
    assert list(_sent(probes, PERIOD_S)) == [STOP, OPEN]
    assert probes.is_open(STOP)


def test_a_lost_probe_closes_its_way_until_one_comes_back() -> None:
    """It is tried again sooner; the other way is none of its business."""
    probes = Probes([STOP, OPEN])
    sent = _sent(probes, 0.0)
    probes.take(OPEN, sent[OPEN], 0.1)
    assert _sent(probes, LIMIT_S) == {}
    assert probes.closed() == []
    assert _sent(probes, LIMIT_S + 0.1) == {}
    assert (probes.closed(), probes.are_tried()) == ([STOP], True)
    again = _sent(probes, AGAIN_S)
    assert list(again) == [STOP]
    assert probes.take(STOP, again[STOP], AGAIN_S + 0.1)
    assert probes.closed() == []


def test_what_comes_late_or_again_proves_nothing() -> None:
    """A Stop would come as late; a bridge may bring one twice, and somebody may send it back."""
    probes = Probes([STOP])
    first = _sent(probes, 0.0)[STOP]
    assert probes.take(STOP, first, LIMIT_S + 0.1)
    assert probes.closed() == [STOP]
    second = _sent(probes, AGAIN_S)[STOP]
    assert second != first
    assert probes.take(STOP, first, AGAIN_S)
    assert probes.closed() == [STOP]
    assert probes.take(STOP, second, AGAIN_S)
    assert probes.take(STOP, second, AGAIN_S)
    assert probes.is_open(STOP)


def test_another_servers_probe_is_no_stop_and_proves_nothing() -> None:
    """The doctor's is one, too; and this one's by another topic."""
    probes, other = Probes([STOP, OPEN]), Probes([STOP])
    own = _sent(probes, 0.0)
    assert probes.take(STOP, _sent(other, 0.0)[STOP], 0.1)
    assert not probes.take(OPEN, own[STOP], 0.1)
    assert not probes.take(STOP, own[OPEN], 0.1)
    assert (probes.is_open(STOP), probes.is_open(OPEN)) == (False, False)


def test_servers_that_know_no_probes_get_none_of_stops() -> None:
    """They would stop: their brokers keep from them what is as large."""
    assert len(_sent(Probes([STOP]), 0.0)[STOP]) >= BEFORE_PROBES_BYTES


@pytest.mark.parametrize("change", [b"", b"x", b" ", b"wax-probe"])
def test_what_only_looks_like_a_probe_is_a_command(change: bytes) -> None:
    """Whatever stands in a Stop, it stops."""
    probe = _sent(Probes([STOP]), 0.0)[STOP]
    for payload in (probe.strip(), probe + change + b"x", change + b"x" + probe, probe[:-1]):
        assert not Probes([STOP]).take(STOP, payload, 0.0)


@given(st.binary(max_size=100) | st.text(max_size=100).map(str.encode))
def test_nobody_means_a_probe(payload: bytes) -> None:
    """No payload as people and their automations send it is one."""
    assert not Probes([STOP]).take(STOP, payload, 0.0)
