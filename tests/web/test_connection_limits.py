"""Limits of connections: no address has them all, and idle ones make room for newcomers."""

from __future__ import annotations

from functools import partial

from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.web.connection_limits import ConnectionLimits, TrackedConnection


class Bed:
    """Limits with named connections, those that were closed, and a clock turned by hand."""

    def __init__(self, *, most: int = 4, most_per_address: int = 2) -> None:
        self.limits = ConnectionLimits(most=most, most_per_address=most_per_address)
        self.closed: list[str] = []
        self.now_s = 0.0

    def enter(self, name: str, address: str, *, limited: bool = True) -> TrackedConnection | None:
        close = partial(self.closed.append, name)
        return self.limits.enter(address, close, self.now_s, limited=limited)

    def comes(self, name: str, address: str, *, answers: bool = False) -> TrackedConnection:
        """Admit one, which must find room."""
        tracked = self.enter(name, address)
        assert tracked is not None
        if answers:
            self.limits.mark_answering(tracked)
        return tracked


def test_one_address_has_a_share() -> None:
    """Beyond its share, only the address's own connections make room, never others'."""
    bed = Bed()
    first = bed.comes("a", "x", answers=True)
    bed.comes("b", "x", answers=True)
    bed.comes("c", "y")
    assert bed.enter("d", "x") is None
    bed.limits.leave(first)
    bed.limits.leave(first)
    bed.comes("e", "x")
    assert (bed.closed, bed.limits.refused) == ([], 1)
    assert (bed.limits.count_of("x"), len(bed.limits)) == (2, 3)


def test_a_trusted_proxy_has_no_share() -> None:
    """A trusted proxy carries everybody's connections."""
    bed = Bed()
    assert all(bed.enter(name, "x", limited=False) for name in "abcd")


def test_silent_neighbours_make_room() -> None:
    """Nobody keeps neighbours out: idle connections close first, then the longest silent."""
    bed = Bed()
    bed.comes("a", "x")
    idle = bed.comes("b", "x")
    bed.limits.mark_answering(idle)
    bed.limits.mark_idle(idle)
    for name in "cdef":
        bed.comes(name, "x")
    assert bed.closed == ["b", "a", "c", "d"]


def test_a_connections_age_is_that_of_its_request() -> None:
    """The connection whose request began first is closed, not the one opened first."""
    bed = Bed()
    first = bed.comes("a", "x")
    bed.comes("b", "x")
    bed.limits.mark_answering(first)
    bed.limits.mark_idle(first)
    bed.limits.mark_reading(first, 1.0)
    bed.comes("c", "x")
    assert bed.closed == ["b"]


def test_a_full_server_closes_a_connection_of_the_address_with_most() -> None:
    """A slow reader with one connection keeps it; of greedy addresses', the oldest closes."""
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


def test_while_all_are_answering_nobody_makes_room() -> None:
    """A request that has only just begun is not cut off for a newcomer."""
    bed = Bed()
    for name in "abcd":
        bed.comes(name, name, answers=True)
    bed.now_s = 0.9
    assert bed.enter("e", "e") is None
    assert bed.closed == []
    bed.now_s = 1.0
    assert bed.enter("e", "e")


def test_an_address_with_fewer_waits_for_no_answer() -> None:
    """Addresses that fill the server at once keep nobody out, not even for the first second."""
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


def test_the_address_that_holds_most_bytes_makes_room() -> None:
    """It loses its largest connection; answered or closed requests no longer count."""
    bed = Bed()
    guest, answered = bed.comes("guest", "g"), bed.comes("answered", "w")
    few, many = bed.comes("few", "x"), bed.comes("many", "x")
    bed.limits.set_held_bytes(answered, 4 * 8192)
    bed.limits.set_held_bytes(answered, 0)
    bed.limits.set_held_bytes(few, 7_000)
    bed.limits.set_held_bytes(many, 20_000)
    bed.limits.count_for(many, "y", 0.0, limited=True)
    bed.limits.count_for(many, "x", 0.0, limited=True)
    assert bed.closed == []
    bed.limits.set_held_bytes(guest, 8192)
    assert bed.closed == ["many"]
    bed.limits.set_held_bytes(many, 20_000)
    bed.limits.set_held_bytes(few, 4 * 8192 - 8192)
    assert bed.closed == ["many"]


def test_a_proxys_connections_count_as_its_clients() -> None:
    """Each client behind it has a share of its own; waiting connections are the proxy's."""
    bed = Bed(most=9)
    all_tracked = [bed.enter(name, "proxy", limited=False) for name in "abc"]
    for tracked, now_s in zip(all_tracked, (0.0, 0.0, 1.0), strict=True):
        assert tracked is not None
        assert bed.limits.count_for(tracked, "troll", now_s, limited=True)
        bed.limits.mark_answering(tracked)
    assert bed.closed == ["a"]
    fourth = bed.enter("d", "proxy", limited=False)
    assert fourth is not None
    assert not bed.limits.count_for(fourth, "troll", 0.5, limited=True), "both have only begun"
    assert bed.limits.count_for(fourth, "guest", 0.5, limited=True)
    assert [bed.limits.count_of(one) for one in ("troll", "guest", "proxy")] == [2, 1, 0]
    assert bed.limits.count_for(fourth, "proxy", 0.5, limited=False)
    assert [bed.limits.count_of(one) for one in ("guest", "proxy")] == [0, 1]
    assert len(bed.limits) == 3


@examples(200)
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 3)), max_size=80))
def test_the_limits_hold_whatever_happens(steps: list[tuple[int, int]]) -> None:
    """Neither the total nor any address ever exceeds its limit, and nothing counts twice."""
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
                bed.limits.count_for(tracked, "zyxw"[which], bed.now_s, limited=True)
            elif what == 1:
                bed.limits.mark_reading(tracked, bed.now_s)
            else:
                (bed.limits.mark_answering, bed.limits.mark_idle)[what - 2](tracked)
        all_tracked = [tracked for tracked in all_tracked if tracked in bed.limits]
        assert len(bed.limits) == len(all_tracked) <= 5
        assert all(sum(one.address == address for one in all_tracked) <= 3 for address in "wxyz")
        assert all(
            bed.limits.count_of(one) == sum(p.address == one for p in all_tracked) for one in "wxyz"
        )
    bed.limits.close_all()
    assert len(bed.closed) >= len(all_tracked)
