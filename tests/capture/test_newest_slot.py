"""The newest-frame slot returns the newest item or nothing, and never spins."""

from __future__ import annotations

import pytest

from wax.capture.newest_slot import NewestSlot


@pytest.fixture
def waited_s(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Record the length of each wait, which takes no real time."""
    found: list[float] = []
    monkeypatch.setattr(
        "threading.Condition.wait", lambda _self, timeout_s: found.append(timeout_s)
    )
    return found


def test_a_newer_item_replaces_what_was_there(waited_s: list[float]) -> None:
    """A late reader gets only the newest item, at once and only once."""
    slot: NewestSlot[str] = NewestSlot()
    for item in "abc":
        slot.put(item)
    assert slot.count == 3
    assert slot.newer_than(1, 0.5) == (3, "c")
    assert waited_s == []
    assert slot.newer_than(3, 0.5) is None
    assert waited_s == [0.5]


@pytest.mark.parametrize("number", [-1, 0])
def test_an_empty_slot_is_waited_for(waited_s: list[float], number: int) -> None:
    """Before the first item a reader waits."""
    assert NewestSlot[str]().newer_than(number, 0.5) is None
    assert waited_s == [0.5]
