"""Who is taken out of a room, how often, and who is not any more."""

from __future__ import annotations

from wax.cluster.leaving import Leaving


def test_each_time_comes_once_and_leaves_nothing() -> None:
    """In the order of time, whoever it is."""
    leaving = Leaving()
    leaving.add("a", (0.0, 5.0))
    leaving.add("b", (1.0,))
    assert [leaving.due(1.0) for _ in range(3)] == ["a", "b", None]
    assert len(leaving) == 1
    assert leaving.due(4.9) is None
    assert [leaving.due(9.0) for _ in range(2)] == ["a", None]
    assert len(leaving) == 0


def test_who_is_let_in_is_not_removed() -> None:
    """Until they have to leave another time."""
    leaving = Leaving()
    leaving.add("a", (0.0, 5.0))
    leaving.let_in("a")
    leaving.let_in("nobody")
    assert leaving.due(9.0) is None
    leaving.add("a", (10.0,))
    assert leaving.due(10.0) == "a"
