"""Which offers are answered: an honest guest gets in whatever others do, and the host always."""

from __future__ import annotations

from contextlib import suppress
from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.errors import FullError, NoPlaceError, TooOftenError
from wax.session.capacity import MOST_SILENT, YIELDS_S, Asking, Capacity

REFUSED: Final = (FullError, TooOftenError)


class Room:
    """Viewers by number, admitted and removed as the class under test says."""

    def __init__(self, *, most: int = 100, share: float = 0.5, silent: int = 2) -> None:
        self.capacity = Capacity(most=most, most_silent_per_address=silent, share_per_address=share)
        self.present: dict[int, Asking] = {}
        self.yielded: list[int] = []
        self._next = 0

    def ask(
        self, address: str, now_s: float, *, is_host: bool = False, is_embed: bool = False
    ) -> int:
        asking = Asking(address, is_host, is_embed=is_embed)
        self._next += 1
        number = self._next
        displaced = self.capacity.admit(number, asking, self.present.values(), now_s)
        if displaced.silent is not None:
            self.yielded.append(displaced.silent)
            del self.present[displaced.silent]
        if displaced.an_embed:
            del self.present[next(key for key, one in self.present.items() if one.is_embed)]
        self.present[number] = asking
        return number

    def join(
        self, address: str, now_s: float, *, is_host: bool = False, is_embed: bool = False
    ) -> int:
        number = self.ask(address, now_s, is_host=is_host, is_embed=is_embed)
        self.capacity.connected(number)
        return number


def test_two_of_an_address_connect_at_once() -> None:
    """A third is told to wait until one has connected, or has been silent for three seconds."""
    room = Room()
    first = room.ask("x", 0.0)
    room.ask("x", 1.0)
    with pytest.raises(TooOftenError, match="your address") as refused:
        room.ask("x", 2.0)
    assert refused.value.retry_after_s == 1
    room.ask("y", 2.0)
    room.capacity.connected(first)
    room.ask("x", 2.0)
    with pytest.raises(TooOftenError) as refused:
        room.capacity.check(Asking("x"), 2.0)
    assert refused.value.retry_after_s == 2
    with pytest.raises(TooOftenError):
        room.capacity.check(Asking("x"), 3.9)
    room.capacity.check(Asking("x"), 4.0)
    assert room.yielded == []
    room.ask("x", 4.0)
    assert room.yielded == [2], "the longest silent of the same address makes room"


def test_a_neighbours_silent_offers_block_for_three_seconds() -> None:
    """However many there were, a guest at that address who retries as told gets in by then."""
    room = Room()
    for number in range(40):
        with suppress(*REFUSED):
            room.ask("x", number / 160)
    now_s = came_s = 0.3
    while True:
        try:
            room.join("x", now_s)
            break
        except TooOftenError as refused:
            now_s += refused.retry_after_s
    assert now_s - came_s <= 3.0


def test_a_returning_operator_comes_first() -> None:
    """Viewers who reconnect without end use up only their own allowance."""
    capacity = Room(most=10).capacity

    def returns(asking: Asking) -> None:
        capacity.admit(1, asking, [], 0.0)

    for _ in range(10):
        returns(Asking("x", has_been_here=True))
    with pytest.raises(FullError, match="coming back"):
        returns(Asking("x", has_been_here=True))
    returns(Asking("x", has_been_here=True, drives=True))
    returns(Asking("x", is_host=True, has_been_here=True))


def test_a_school_behind_one_address_gets_in() -> None:
    """Thirty pages that connect one after another do not use up their silent places."""
    room = Room()
    for number in range(30):
        room.join("school", number / 8)
    assert len(room.present) == 30


def test_a_repeated_offer_takes_another_place() -> None:
    """A page that offers again and again without connecting does not get around the limit."""
    room = Room()
    for _ in range(2):
        room.capacity.admit(1, Asking("x"), [], 0.0)
    with pytest.raises(TooOftenError):
        room.capacity.admit(1, Asking("x"), [], 0.0)
    room.capacity.connected(1)
    room.capacity.admit(2, Asking("x"), [], 0.0)


def _fill(room: Room, number: int, now_s: float = 0.0) -> None:
    """Have `number` addresses offer, as fast as offers are answered, and stay silent."""
    for one in range(number):
        room.ask(f"troll {one}", now_s + one / 8)


def test_a_guest_gets_in_while_all_are_silent() -> None:
    """They take over the oldest silent place, once its viewer has had a moment to connect."""
    room = Room()
    for number in range(8):
        room.ask(f"early {number}", 0.0)
    _fill(room, MOST_SILENT - 8, 0.125)
    with pytest.raises(FullError, match="come in shortly"):
        room.ask("guest", 2.99)
    room.join("guest", 3.13)
    assert room.yielded == [1]


def test_a_page_that_has_just_come_keeps_its_place() -> None:
    """Where older ones yield, no address that failed before loses the place it just got."""
    room = Room(silent=1)
    room.ask("school", 0.0)
    _fill(room, MOST_SILENT - 1, 0.125)
    full_s = MOST_SILENT / 8
    young = room.ask("school", full_s)
    room.join("guest", full_s + 0.5)
    assert young not in room.yielded


def test_an_embed_that_must_wait_uses_up_nothing() -> None:
    """However often frames ask in vain, the next one whose turn it is gets in."""
    room = Room()
    for number in range(8):
        room.ask(f"{number}", 0.0)
    for _ in range(10):
        with pytest.raises(FullError, match="come in shortly"):
            room.ask("frame", 0.0, is_embed=True)
    room.join("frame", 0.25, is_embed=True)


def test_answers_are_spread() -> None:
    """However many offers come at once: the event loop has other things to do."""
    room = Room()
    for number in range(8):
        room.ask(f"{number}", 0.0)
    with pytest.raises(FullError, match="come in shortly"):
        room.ask("8", 0.0)
    room.ask("8", 0.125)


def test_the_host_always_gets_in() -> None:
    """However many places are taken or silent; but with a bounded number of pages."""
    room = Room(most=40)
    _fill(room, 20)
    with pytest.raises(FullError, match="come in shortly"):
        room.ask("guest", 2.5)
    room.join("host", 2.5, is_host=True)
    for number in range(20):
        room.join(f"guest {number}", 20.0 + number)
    with pytest.raises(FullError, match="40 places"):
        room.join("guest", 40.0)
    for _ in range(7):
        room.join("host", 40.0, is_host=True)
    with pytest.raises(FullError, match="40 places"):
        room.join("host", 40.0, is_host=True)


def test_a_host_may_open_many_pages() -> None:
    """Beyond the host's own places, pages of the host take everybody's."""
    room = Room(most=2)
    for _ in range(10):
        room.join("host", 0.0, is_host=True)
    with pytest.raises(FullError, match="2 places"):
        room.join("guest", 0.0)


def test_one_address_has_a_share_of_the_places() -> None:
    """The other places are left for others."""
    room = Room(most=10)
    for now_s in range(5):
        room.join("x", now_s)
    with pytest.raises(FullError, match="5 places for your address"):
        room.join("x", 5.0)
    for now_s in range(5):
        room.join("y", 5.0 + now_s)
    with pytest.raises(FullError, match="10 places"):
        room.join("z", 10.0)


def test_everybody_may_come_back_at_once() -> None:
    """After an outage all return without a silent place; a page that returns for ever is slowed."""
    capacity = Room(most=20).capacity
    back = Asking("x", has_been_here=True)
    for number in range(20):
        capacity.admit(number, back, [], 0.0)
    with pytest.raises(FullError, match="coming back"):
        capacity.admit(1, back, [], 0.0)
    capacity.admit(1, back, [], 0.1)


def test_an_unknown_address_has_only_the_general_limits() -> None:
    """The limits for one address cannot count it."""
    room = Room(most=100)
    for number in range(20):
        room.ask("", number / 8)
    room.capacity.check(Asking(""), 2.5)


@examples(300)
@given(
    st.lists(
        st.tuples(st.floats(0, 4), st.sampled_from("abcdefgh"), st.booleans(), st.integers(0, 3)),
        max_size=150,
    )
)
def test_the_limits_hold_whatever_happens(steps: list[tuple[float, str, bool, int]]) -> None:
    """No address has more than two unused answers in three seconds, nor more than its share."""
    room = Room(most=12, share=0.5)
    now_s, silent = 0.0, list[tuple[float, str, int]]()
    for wait_s, address, is_host, what in steps:
        now_s += wait_s
        if what == 0 and silent:
            number = silent.pop(0)[2]
            room.capacity.connected(number)
        try:
            number = room.ask(address, now_s, is_host=is_host)
        except REFUSED:
            continue
        if not is_host:
            silent.append((now_s, address, number))
        recent = [one for one in silent if now_s - one[0] < YIELDS_S]
        assert all(sum(one[1] == name for one in recent) <= 2 for name in "abcdefgh")
        guests = [one for one in room.present.values() if not one.is_host]
        assert len(guests) <= 12
        assert all(sum(one.address == name for one in guests) <= 6 for name in "abcdefgh")


@examples(200)
@given(
    most=st.integers(1, 60),
    waits_s=st.lists(st.tuples(st.floats(0, 2), st.booleans()), max_size=80),
)
def test_embeds_leave_all_places_to_guests(most: int, waits_s: list[tuple[float, bool]]) -> None:
    """However many come, connected or not, they hold a quarter of the places while it is free."""
    room, now_s = Room(most=most, share=1.0), 0.0
    for number, (wait_s, connects) in enumerate(waits_s):
        now_s += wait_s
        with suppress(*REFUSED):
            (room.join if connects else room.ask)(f"site {number}", now_s, is_embed=True)
    assert len(room.present) <= max(1, most // 4)
    for number in range(most):
        now_s += 1
        room.join(f"guest {number}", now_s)
        assert len(room.present) <= most
    assert not any(one.is_embed for one in room.present.values())
    with pytest.raises(NoPlaceError):
        room.ask("site", now_s, is_embed=True)


def test_a_crowd_of_embeds_leaves_the_answers_to_guests() -> None:
    """Embeds get a quarter of the answers, and guests get theirs at the same time."""
    room = Room(most=400)
    answered = 0
    for number in range(100):
        with suppress(*REFUSED):
            room.join(f"site {number}", number / 100, is_embed=True)
            answered += 1
        if number % 20 == 0:
            room.join(f"guest {number}", number / 100)
    assert answered <= 4


@pytest.mark.parametrize(
    ("most", "sources", "rate_hz", "known_s"),
    [
        *((100, 20, 50, 0.0), (10, 20, 50, 6.0), (100, 50, 200, 6.0), (100, 64, 50, 6.0)),
        *((100, 250, 50, 6.0), (100, 600, 100, 6.0)),
    ],
)
def test_abandoned_offers_keep_no_newcomer_out(
    most: int, sources: int, rate_hz: int, known_s: float
) -> None:
    """A guest who retries as told is in within three seconds, once the others are known."""
    room = Room(most=most)
    waits_s: list[float] = []
    came_s = again_s = known_s
    for step in range(20 * rate_hz):
        now_s = step / rate_hz
        with suppress(*REFUSED):
            room.ask(f"troll {step % sources}", now_s)
        if now_s < again_s:
            continue
        try:
            number = room.join("guest", now_s)
        except REFUSED as refused:
            again_s = now_s + refused.retry_after_s
        else:
            del room.present[number]
            waits_s.append(now_s - came_s)
            came_s = again_s = now_s + 0.7
    assert len(waits_s) > 5
    assert max(waits_s) <= 3.0


def test_a_connection_clears_its_address() -> None:
    """Until then, addresses that abandoned an offer share one silent place in four."""
    room = Room(most=20)
    for number in range(8):
        room.ask(f"{number}", 0.0)
    first = room.ask("0", 10.0)
    room.ask("1", 10.0)
    with pytest.raises(FullError, match="come in shortly"):
        room.ask("2", 12.0)
    room.capacity.connected(first)
    room.ask("2", 12.0)
    room.ask("0", 12.0)
    for number in range(3, 6):
        room.ask(f"{number}", 70.1)
