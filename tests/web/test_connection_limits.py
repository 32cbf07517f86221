"""Connections: nobody has them all, and who waits makes room for who asks."""

from __future__ import annotations

from functools import partial

from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.web.connection_limits import ConnectionLimits, TrackedConnection


class Bed:
    """Connections by name, and which were closed to make room; the clock is turned by hand."""

    def __init__(self, *, most: int = 4, most_per_address: int = 2) -> None:
        self.limits = ConnectionLimits(most=most, most_per_address=most_per_address)
        self.closed: list[str] = []
        self.now_s = 0.0

    def enter(self, name: str, address: str, *, limited: bool = True) -> TrackedConnection | None:
        close = partial(self.closed.append, name)
        return self.limits.enter(address, close, self.now_s, limited=limited)

    def comes(self, name: str, address: str, *, answers: bool = False) -> TrackedConnection:
        """Let one enter that must find room."""
        tracked = self.enter(name, address)
        assert tracked is not None
        if answers:
            self.limits.answers(tracked)
        return tracked


def test_one_address_has_a_share() -> None:
    """Beyond it its own make room, never others'."""
    bed = Bed()
    first = bed.comes("a", "x", answers=True)
    bed.comes("b", "x", answers=True)
    bed.comes("c", "y")
    assert bed.enter("d", "x") is None
    bed.limits.leave(first)
    bed.limits.leave(first)
    bed.comes("e", "x")
    assert (bed.closed, bed.limits.refused, bed.limits.of("x"), len(bed.limits)) == ([], 1, 2, 3)


def test_a_trusted_proxy_has_no_share() -> None:
    """It brings everybody's connections."""
    bed = Bed()
    assert all(bed.enter(name, "x", limited=False) for name in "abcd")


def test_a_neighbour_who_is_silent_makes_room() -> None:
    """Nobody keeps others of their address out: idle ones yield, then the longest silent."""
    bed = Bed()
    bed.comes("a", "x")
    idle = bed.comes("b", "x")
    bed.limits.answers(idle)
    bed.limits.idles(idle)
    for name in "cdef":
        bed.comes(name, "x")
    assert bed.closed == ["b", "a", "c", "d"]


def test_a_request_that_began_again_is_not_the_longest() -> None:
    """What counts is when the request began, not the connection."""
    bed = Bed()
    first = bed.comes("a", "x")
    bed.comes("b", "x")
    bed.limits.answers(first)
    bed.limits.idles(first)
    bed.limits.begins(first, 1.0)
    bed.comes("c", "x")
    assert bed.closed == ["b"]


def test_a_full_house_takes_from_who_has_most() -> None:
    """Whoever reads slowly but has one connection keeps it; of the greedy the oldest goes."""
    bed = Bed(most=6, most_per_address=3)
    bed.comes("modem", "m", answers=True)
    bed.now_s = 5.0
    for name in "abc":
        bed.comes(name, "x", answers=True)
    for name in "de":
        bed.comes(name, "y", answers=True)
    bed.now_s = 6.5
    bed.comes("f", "z")
    bed.comes("g", "z")
    assert bed.closed == ["a", "b"]


def test_when_all_are_at_work_nobody_makes_room() -> None:
    """A request that has only just begun is not broken off for a newcomer."""
    bed = Bed()
    for name in "abcd":
        bed.comes(name, name, answers=True)
    bed.now_s = 0.9
    assert bed.enter("e", "e") is None
    assert bed.closed == []
    bed.now_s = 1.0
    assert bed.enter("e", "e")


def test_whoever_has_fewer_waits_for_no_answer() -> None:
    """Addresses that fill the house at once keep nobody out, not even for the first second."""
    bed = Bed(most=6, most_per_address=3)
    for name in "abc":
        bed.comes(name, "x", answers=True)
    for name in "def":
        bed.comes(name, "y", answers=True)
    bed.comes("first", "guest")
    assert bed.closed == ["a"]
    bed.comes("second", "guest")
    assert bed.closed == ["a", "d"]
    assert bed.enter("third", "guest") is None, "now nobody has more"


def test_who_holds_most_of_requests_makes_room() -> None:
    """The address that holds most loses its largest; what is answered or gone is held no longer."""
    bed = Bed()
    guest, answered = bed.comes("guest", "g"), bed.comes("answered", "w")
    few, many = bed.comes("few", "x"), bed.comes("many", "x")
    bed.limits.holds(answered, 4 * 12_288)
    bed.limits.holds(answered, 0)
    bed.limits.holds(few, 10_000)
    bed.limits.holds(many, 30_000)
    bed.limits.is_for(many, "y", 0.0, limited=True)
    bed.limits.is_for(many, "x", 0.0, limited=True)
    assert bed.closed == []
    bed.limits.holds(guest, 12_288)
    assert bed.closed == ["many"]
    bed.limits.holds(many, 30_000)
    bed.limits.holds(few, 4 * 12_288 - 12_288)
    assert bed.closed == ["many"]


def test_a_proxys_connections_count_for_those_who_ask() -> None:
    """One client behind it has a share, others have their own, and waiting ones are the proxy's."""
    bed = Bed(most=9)
    all_tracked = [bed.enter(name, "proxy", limited=False) for name in "abc"]
    for tracked, now_s in zip(all_tracked, (0.0, 0.0, 1.0), strict=True):
        assert tracked is not None
        assert bed.limits.is_for(tracked, "troll", now_s, limited=True)
        bed.limits.answers(tracked)
    assert bed.closed == ["a"]
    fourth = bed.enter("d", "proxy", limited=False)
    assert fourth is not None
    assert not bed.limits.is_for(fourth, "troll", 0.5, limited=True), "both have only begun"
    assert bed.limits.is_for(fourth, "guest", 0.5, limited=True)
    assert (bed.limits.of("troll"), bed.limits.of("guest"), bed.limits.of("proxy")) == (2, 1, 0)
    assert bed.limits.is_for(fourth, "proxy", 0.5, limited=False)
    assert (bed.limits.of("guest"), bed.limits.of("proxy"), len(bed.limits)) == (0, 1, 3)


@examples(200)
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 3)), max_size=80))
def test_the_limits_hold_whatever_happens(steps: list[tuple[int, int]]) -> None:
    """Neither in all nor for one address are there ever more, and nothing is counted twice."""
    bed = Bed(most=5, most_per_address=3)
    all_tracked: list[TrackedConnection] = []
    for number, (what, which) in enumerate(steps):
        bed.now_s = number / 4
        if what == 0:
            tracked = bed.enter("", "wxyz"[which])
            all_tracked += [tracked] if tracked is not None else []
        elif all_tracked:
            tracked = all_tracked[which % len(all_tracked)]
            if what == 4:
                all_tracked.remove(tracked)
                bed.limits.leave(tracked)
            elif what == 5:
                bed.limits.is_for(tracked, "zyxw"[which], bed.now_s, limited=True)
            elif what == 1:
                bed.limits.begins(tracked, bed.now_s)
            else:
                (bed.limits.answers, bed.limits.idles)[what - 2](tracked)
        all_tracked = [tracked for tracked in all_tracked if tracked in bed.limits]
        assert len(bed.limits) == len(all_tracked) <= 5
        assert all(sum(one.address == address for one in all_tracked) <= 3 for address in "wxyz")
        assert all(
            bed.limits.of(one) == sum(p.address == one for p in all_tracked) for one in "wxyz"
        )
    bed.limits.close_all()
    assert len(bed.closed) >= len(all_tracked)
