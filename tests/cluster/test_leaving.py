"""Whom to remove from a room, when, and whose removal is cancelled."""

from __future__ import annotations

from wax.cluster.leaving import Leaving


def test_each_time_comes_once_and_leaves_nothing() -> None:
    """Removals are due in the order of their times, once each, and are then forgotten."""
    leaving = Leaving()
    leaving.add("a", (0.0, 5.0))
    leaving.add("b", (1.0,))
    assert [leaving.due(1.0) for _ in range(3)] == ["a", "b", None]
    assert len(leaving) == 1
    assert leaving.due(4.9) is None
    assert [leaving.due(9.0) for _ in range(2)] == ["a", None]
    assert len(leaving) == 0


def test_who_is_let_in_is_not_removed() -> None:
    """A cancelled removal is not due; a later one of the same person is."""
    leaving = Leaving()
    leaving.add("a", (0.0, 5.0))
    leaving.cancel("a")
    leaving.cancel("nobody")
    assert leaving.due(9.0) is None
    leaving.add("a", (10.0,))
    assert leaving.due(10.0) == "a"
