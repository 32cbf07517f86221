"""The stop that lasts until it is released."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from tests.control.rules import VOUCHED

from wax.control.reasons import Refusal
from wax.control.stop_latch import LatchedStop, Releaser, StopLatch, press, release
from wax.control.turn_view import TurnView
from wax.sentence import says

ADA, BOB = 1, 2
TURN = TurnView(number=3, operator=ADA, present=True, one_way_s=0.1, sees=True, picture=VOUCHED)
PRESSED = press(press(StopLatch(newest=1), says("Bob"), 90.0), says("Eve"), 100.0)
NOW_S = 101.0


def test_numbers_only_rise() -> None:
    """Each stop has the next number; pressing again keeps it, and the name of who was first."""
    assert PRESSED.stop == LatchedStop(2, says("Bob"))
    free, refusal = release(PRESSED, ADA, 2, NOW_S, turn=TURN, now_s=NOW_S)
    assert refusal is None
    assert free.stop is None
    assert press(free, says("Ada"), NOW_S).stop == LatchedStop(3, says("Ada"))


def test_a_guessed_number_releases_nothing() -> None:
    """A release with the right number that was sent before the stop was pressed is no answer."""
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


@pytest.mark.parametrize(("by", "number", "sent_s"), RELEASED.values(), ids=RELEASED)
def test_released(by: Releaser, number: int, sent_s: float | None) -> None:
    """The operator and the host can release the stop."""
    after, refusal = release(PRESSED, by, number, sent_s, turn=TURN, now_s=NOW_S)
    assert refusal is None
    assert after == replace(PRESSED, stop=None)


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
            replace(latch, stop=None),
            None,
        )


def test_who_pressed_first_is_known() -> None:
    """The stop names the viewer who pressed it first, by whose pressing no clock stands still."""
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
    """A release that was under way for longer than two seconds counts no more."""
    assert release(PRESSED, ADA, 2, 100.5, turn=TURN, now_s=102.5)[1] is None
    late = release(PRESSED, ADA, 2, 100.5, turn=TURN, now_s=102.501)
    assert late == (PRESSED, Refusal.RELEASED_LATE)


def test_what_is_not_latched_is_not_released() -> None:
    """A release while no stop lasts is refused, also a repeated one."""
    free, _ = release(PRESSED, ADA, 2, 100.5, turn=TURN, now_s=NOW_S)
    assert release(free, ADA, 2, 100.5, turn=TURN, now_s=NOW_S) == (free, Refusal.OTHER_STOP)
