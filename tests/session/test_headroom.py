"""Whether the event loop has time for one more viewer."""

from __future__ import annotations

import pytest
from tests.turned_clock import TurnedClock

from wax.session.headroom import CORES_SHARE, FIRST_DOZEN, LOOP_SHARE, Headroom, Used

SERVED = 20


def sampled(
    loop: float, *, process: float = 0.0, charged: float = 0.0, before: float = 0.0
) -> Headroom:
    """Sample for 10 s with these shares of a core, after as long with the share `before`."""
    clock = TurnedClock()
    headroom = Headroom(2.0, clock, lambda: 0.0)
    used = Used(5.0, 9.0, 1.0)
    for share in [before] * 10 + [loop] * 11:
        headroom.sample(used)
        clock.time_s += 1.0
        used = Used(used.loop_s + share, used.process_s + share + process, used.charged_s + charged)
    return headroom


def test_one_more_fits_while_the_loop_has_time_for_them() -> None:
    """The newcomer counts as much as the average of those who are here."""
    fits = LOOP_SHARE * SERVED / (SERVED + 1)
    assert sampled(fits - 0.001).has_time(SERVED)
    assert not sampled(fits + 0.001).has_time(SERVED)


def test_what_somebody_is_charged_for_keeps_nobody_out() -> None:
    """Strangers' floods and demanding viewers are made to wait themselves."""
    assert sampled(0.9, charged=0.5).has_time(SERVED)


def test_the_first_dozen_come_in_however_busy_the_machine_is() -> None:
    """A machine that is busy with something else still serves a dozen."""
    busy = sampled(1.0)
    assert busy.has_time(FIRST_DOZEN - 1)
    assert not busy.has_time(FIRST_DOZEN)


@pytest.mark.parametrize(("more", "fits"), [(-0.01, True), (0.01, False)])
def test_nobody_more_fits_where_all_cores_are_busy(more: float, *, fits: bool) -> None:
    """On a machine with one core, the encoders alone may use it up."""
    others = 2.0 * CORES_SHARE - 0.21 + more
    assert sampled(0.2, process=others).has_time(SERVED) is fits


def test_a_rush_is_over_after_ten_seconds() -> None:
    """Older samples no longer count, and at the start there is time."""
    assert sampled(0.3, before=1.0).has_time(SERVED)
    assert Headroom(2.0, TurnedClock(), lambda: 0.0).has_time(SERVED)
