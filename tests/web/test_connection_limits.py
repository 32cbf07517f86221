"""Places for connections: nobody takes them all, and who waits makes room for who asks."""

from __future__ import annotations

from functools import partial

from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.web.connection_limits import ConnectionLimits, Place


class Bed:
    """Connections by name, and which were closed to make room."""

    def __init__(self, *, most: int = 4, most_per_address: int = 2) -> None:
        self.limits = ConnectionLimits(most=most, most_per_address=most_per_address)
        self.closed: list[str] = []

    def enter(self, name: str, address: str, *, limited: bool = True) -> Place | None:
        return self.limits.enter(address, partial(self.closed.append, name), limited=limited)


def test_one_address_has_a_share() -> None:
    """Beyond it no further connection, until one leaves; others are served."""
    bed = Bed()
    first = bed.enter("a", "x")
    assert first is not None
    assert bed.enter("b", "x")
    assert bed.enter("c", "x") is None
    assert bed.enter("d", "y")
    bed.limits.leave(first)
    bed.limits.leave(first)
    assert bed.enter("e", "x")
    assert (bed.closed, bed.limits.refused, len(bed.limits)) == ([], 1, 3)


def test_a_trusted_proxy_has_no_share() -> None:
    """It brings everybody's connections."""
    bed = Bed()
    assert all(bed.enter(name, "x", limited=False) for name in "abcd")


def test_an_idle_connection_of_the_same_address_makes_room() -> None:
    """A class behind one address need not wait until idle connections end by themselves."""
    bed = Bed()
    idle = bed.enter("a", "x")
    assert idle is not None
    bed.enter("b", "x")
    bed.limits.idles(idle)
    assert bed.enter("c", "x")
    assert bed.closed == ["a"]
    assert bed.enter("d", "x") is None


def test_who_makes_room_when_all_places_are_taken() -> None:
    """Idle ones first, then those that have been reading for longest, and never one at work."""
    bed = Bed()
    places = [bed.enter(name, name) for name in "abcd"]
    idle, working = places[1], places[0]
    assert idle is not None
    assert working is not None
    bed.limits.answers(working)
    bed.limits.idles(idle)
    assert bed.enter("e", "e")
    assert bed.closed == ["b"]
    assert bed.enter("f", "f")
    assert bed.closed == ["b", "c"]
    for place in places[2:]:
        assert place is not None
    bed.limits.reads(working)
    assert bed.enter("g", "g")
    assert bed.closed == ["b", "c", "d"]
    assert len(bed.limits) == 4


def test_when_all_are_at_work_nobody_makes_room() -> None:
    """A request under way is not broken off for a newcomer."""
    bed = Bed()
    for name in "abcd":
        place = bed.enter(name, name)
        assert place is not None
        bed.limits.answers(place)
    assert bed.enter("e", "e") is None
    assert bed.closed == []


@examples(200)
@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 3)), max_size=80))
def test_the_limits_hold_whatever_happens(steps: list[tuple[int, int]]) -> None:
    """Neither in all nor for one address are there ever more, and nothing is counted twice."""
    bed = Bed(most=5, most_per_address=3)
    places: list[Place] = []
    for what, which in steps:
        if what == 0:
            place = bed.enter("", "wxyz"[which])
            places += [place] if place is not None else []
        elif places:
            place = places[which % len(places)]
            if what == 4:
                places.remove(place)
                bed.limits.leave(place)
            elif place in bed.limits:
                (bed.limits.reads, bed.limits.answers, bed.limits.idles)[what - 1](place)
        places = [place for place in places if place in bed.limits]
        assert len(bed.limits) == len(places) <= 5
        assert all(sum(one.address == address for one in places) <= 3 for address in "wxyz")
    bed.limits.close_all()
    assert len(bed.closed) >= len(places)
