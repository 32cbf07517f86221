"""The stop that lasts until it is released."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from typing import cast

import pytest
from tests.control.rules import VOUCHED

from wax.control.reasons import Refusal
from wax.control.stop_latch import (
    LatchedStop,
    Releaser,
    StopLatch,
    adds_nothing,
    press,
    release,
)
from wax.control.turn_view import TurnView
from wax.protocol.messages import StopInfo
from wax.sentence import says

ADA, BOB = 1, 2
TURN = TurnView(number=3, operator=ADA, present=True, one_way_s=0.1, sees=True, picture=VOUCHED)
PRESSED = press(press(StopLatch(newest=1), says("Bob"), 90.0), says("Eve"), 100.0)
NOW_S = 101.0


def test_pages_are_told_all_of_it() -> None:
    """The message about a stop has the latch's fields, so that a further one is named alike."""
    stop = LatchedStop(4, says("Bob"), viewer=BOB, by_host=True)
    assert StopInfo.model_validate(stop).model_dump() == asdict(stop)


def test_numbers_only_rise() -> None:
    """Each stop has the next number; pressing again keeps it and the first presser's name."""
    assert PRESSED.stop == LatchedStop(2, says("Bob"))
    free, refusal = release(PRESSED, ADA, 2, NOW_S, turn=TURN, now_s=NOW_S)
    assert refusal is None
    assert free.stop is None
    assert press(free, says("Ada"), NOW_S).stop == LatchedStop(3, says("Ada"))


def test_a_guessed_number_releases_nothing() -> None:
    """A release sent before the stop was pressed has no effect, even with the right number."""
    latch = press(StopLatch(), says("Bob"), 100.0)
    for sent_s, expected in ((99.999, Refusal.OTHER_STOP), (100.0, None)):
        assert release(latch, ADA, 1, sent_s, turn=TURN, now_s=NOW_S)[1] is expected


RELEASED = {
    "the operator": (ADA, 2, 100.5),
    "the host": ("host", 2, 100.5),
    "the house": ("house", 2, 100.5),
    "without a stamp": (ADA, 2, None),
    "at the moment of the press": (ADA, 2, 100.0),
    "a stamp ahead by the line's delay": (ADA, 2, 101.149),
    "the host's stamp, a little ahead": ("host", 2, 101.049),
}
LOST_TURN = replace(TURN, present=False)


@pytest.mark.parametrize(("by", "number", "sent_s"), RELEASED.values(), ids=RELEASED)
def test_released(by: Releaser, number: int, sent_s: float | None) -> None:
    """The operator and the host can release the stop."""
    after, refusal = release(PRESSED, by, number, sent_s, turn=TURN, now_s=NOW_S)
    assert refusal is None
    assert after == StopLatch(newest=2, pressed_s=100.0)
    if by != ADA:
        assert release(PRESSED, by, number, sent_s, turn=LOST_TURN, now_s=NOW_S)[1] is None


def test_only_the_host_releases_the_hosts_stop() -> None:
    """A stop that the host has pressed, first or again, is released by the host alone."""
    first = press(StopLatch(), says("the host"), 99.0, by_host=True)
    again = press(
        press(StopLatch(), says("Bob"), 98.0, viewer=BOB), says("the host"), 99.0, by_host=True
    )
    for latch in (first, again, press(again, says("Ada"), 99.5, viewer=ADA)):
        for other in (ADA, "house"):
            refusal = release(latch, other, 1, 100.0, turn=TURN, now_s=NOW_S)[1]
            assert refusal is Refusal.THE_HOSTS_STOP
        assert release(latch, "host", 1, 100.0, turn=TURN, now_s=NOW_S) == (
            StopLatch(newest=1, pressed_s=latch.pressed_s),
            None,
        )


def test_who_pressed_first_is_known() -> None:
    """The stop names the viewer who pressed it first, whose own turn it does not pause."""
    latch = press(press(StopLatch(), says("Bob"), 98.0, viewer=BOB), says("Ada"), 99.0, viewer=ADA)
    assert latch.stop == LatchedStop(1, says("Bob"), BOB)


REFUSED = {
    "somebody else": (Refusal.NOT_YOUR_STOP, (BOB, 2, 100.5), {}),
    "a lost operator": (Refusal.LOST, (ADA, 2, 100.5), {"present": False}),
    "somebody else, of another stop": (Refusal.NOT_YOUR_STOP, (BOB, 3, 100.5), {}),
    "nobody's turn": (Refusal.NOT_YOUR_STOP, (ADA, 2, 100.5), {"operator": None}),
    "somebody unknown": (Refusal.NOT_YOUR_STOP, (None, 2, 100.5), {}),
    "somebody unknown, in nobody's turn": (
        Refusal.NOT_YOUR_STOP,
        (None, 2, 100.5),
        {"operator": None},
    ),
    "an earlier stop": (Refusal.OTHER_STOP, (ADA, 1, 100.5), {}),
    "an earlier press, without a stamp": (Refusal.OTHER_STOP, ("host", 1, None), {}),
    "a later stop": (Refusal.OTHER_STOP, ("host", 3, None), {}),
    "sent before the last press": (Refusal.OTHER_STOP, (ADA, 2, 99.999), {}),
    "the future": (Refusal.FROM_FUTURE, (ADA, 2, 101.151), {}),
    "the host's future": (Refusal.FROM_FUTURE, ("host", 2, 101.051), {}),
    "the house's future": (Refusal.FROM_FUTURE, ("house", 2, 101.051), {}),
    "no number as a stamp": (Refusal.RELEASED_LATE, (ADA, 2, math.nan), {}),
}


@pytest.mark.parametrize(("why", "asked", "change"), REFUSED.values(), ids=REFUSED)
def test_refused(
    why: Refusal, asked: tuple[Releaser, int, float | None], change: dict[str, object]
) -> None:
    """A release that breaks one rule is refused for it, and the stop lasts."""
    turn = replace(TURN, **change)  # type: ignore[arg-type]  # a table
    assert release(PRESSED, *asked, turn=turn, now_s=NOW_S) == (PRESSED, why)


def test_release_is_good_for_two_seconds() -> None:
    """A release that took longer than two seconds to arrive has no effect."""
    assert release(PRESSED, ADA, 2, 100.5, turn=TURN, now_s=102.5)[1] is None
    late = release(PRESSED, ADA, 2, 100.5, turn=TURN, now_s=102.501)
    assert late == (PRESSED, Refusal.RELEASED_LATE)


def test_what_is_not_latched_is_not_released() -> None:
    """A release without a stop in force is refused, even a repeated one."""
    free, _ = release(PRESSED, ADA, 2, 100.5, turn=TURN, now_s=NOW_S)
    assert release(free, ADA, 2, 100.5, turn=TURN, now_s=NOW_S) == (free, Refusal.OTHER_STOP)


RELEASE_AFTER_S = 3.0


def pressed(*presses: tuple[int | None, float]) -> StopLatch:
    latch = StopLatch()
    for viewer, now_s in presses:
        latch = press(latch, says("?"), now_s, viewer=viewer, release_after_s=RELEASE_AFTER_S)
    return latch


EVE = 3
EARLY = {
    "somebody else's": (((BOB, 0.0),), 3.0),
    "one from outside the room": (((None, 0.0),), 3.0),
    "the operator's own": (((ADA, 0.0),), 0.0),
    "the operator's own, twice": (((ADA, 0.0), (ADA, 1.0)), 1.0),
    "again by the same": (((BOB, 0.0), (BOB, 2.9)), 3.0),
    "again by another, once longer": (((BOB, 0.0), (EVE, 1.0)), 4.0),
    "not twice longer": (((BOB, 0.0), (EVE, 1.0), (BOB, 3.9), (None, 3.9)), 4.0),
    "the operator's behind somebody else's": (((BOB, 0.0), (ADA, 1.0)), 4.0),
    "somebody else's behind the operator's": (((ADA, 0.0), (BOB, 2.9)), 5.9),
    "again by the same, later": (((BOB, 0.0), (BOB, 3.0)), 6.0),
    "the operator's, when somebody else's may be released": (((BOB, 0.0), (ADA, 3.0)), 3.0),
}


@pytest.mark.parametrize(("presses", "until_s"), EARLY.values(), ids=EARLY)
def test_the_operator_releases_somebody_elses_stop_later(
    presses: tuple[tuple[int | None, float], ...], until_s: float
) -> None:
    """Somebody else's stop lasts for its time before an operator may release it."""
    latch, newest_s = pressed(*presses), presses[-1][1]
    for now_s in (newest_s, until_s - 0.001):
        if newest_s <= now_s < until_s:
            asked = release(latch, ADA, 1, None, turn=TURN, now_s=now_s)
            assert asked == (latch, Refusal.RELEASED_EARLY)
    for releaser, now_s in ((ADA, max(newest_s, until_s)), ("host", newest_s), ("house", newest_s)):
        by = cast("Releaser", releaser)
        assert release(latch, by, 1, None, turn=TURN, now_s=now_s)[1] is None


def test_the_next_stop_has_its_own_time() -> None:
    """A stop pressed after an early release by the host gets its own full delay."""
    free, _ = release(pressed((BOB, 0.0)), "host", 1, None, turn=TURN, now_s=1.0)
    assert not adds_nothing(free, BOB, 1.0)
    latch = press(free, says("Bob"), 1.0, viewer=BOB, release_after_s=RELEASE_AFTER_S)
    assert release(latch, ADA, 2, None, turn=TURN, now_s=3.999)[1] is Refusal.RELEASED_EARLY
    assert release(latch, ADA, 2, None, turn=TURN, now_s=4.0)[1] is None


def test_what_a_press_adds() -> None:
    """A press before the release adds nothing, unless another viewer alone has pressed the stop."""
    latch = pressed((BOB, 0.0))
    assert adds_nothing(latch, BOB, 2.9)
    assert not adds_nothing(latch, EVE, 2.9)
    assert not adds_nothing(latch, BOB, 3.0)
    assert adds_nothing(pressed((BOB, 0.0), (EVE, 1.0)), ADA, 3.9)


def test_a_press_that_adds_nothing_is_still_one() -> None:
    """Such a press still invalidates earlier releases, and still makes the stop the host's."""
    latch = press(pressed((None, 0.0)), says("the host"), 1.0, by_host=True)
    assert latch.stop is not None
    assert latch.stop.by_host
    assert release(latch, "host", 1, 0.9, turn=TURN, now_s=1.0)[1] is Refusal.OTHER_STOP


def test_an_early_release_of_another_stop_is_of_another_stop() -> None:
    """A release of another stop is refused as such, even if it is also too early."""
    early = release(pressed((BOB, 0.0)), ADA, 2, None, turn=TURN, now_s=0.0)
    assert early[1] is Refusal.OTHER_STOP


def test_without_a_time_of_its_own_a_stop_may_be_released_at_once() -> None:
    """With a delay of 0 the operator may release any stop at once."""
    latch = press(StopLatch(), says("Bob"), 0.0, viewer=BOB)
    assert release(latch, ADA, 1, None, turn=TURN, now_s=0.0)[1] is None
