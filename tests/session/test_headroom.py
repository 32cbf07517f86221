"""For whom the event loop has time."""

from __future__ import annotations

import pytest
from tests.turned_clock import TurnedClock

from wax.session.headroom import CORES_SHARE, LOOP_SHARE, Headroom, Used

SERVED = 20


def looked(
    loop: float, *, process: float = 0.0, charged: float = 0.0, before: float = 0.0
) -> Headroom:
    """Look for 10 s at so many seconds of each second, after as long with another share."""
    clock = TurnedClock()
    headroom = Headroom(2.0, clock, lambda: 0.0)
    used = Used(5.0, 9.0, 1.0)
    for share in [before] * 10 + [loop] * 11:
        headroom.look(used)
        clock.time_s += 1.0
        used = Used(used.loop_s + share, used.process_s + share + process, used.charged_s + charged)
    return headroom


def test_one_more_fits_while_the_loop_has_time_for_them() -> None:
    """By what each of those who are here takes of it on the average."""
    fits = LOOP_SHARE * SERVED / (SERVED + 1)
    assert looked(fits - 0.001).has_time(SERVED)
    assert not looked(fits + 0.001).has_time(SERVED)


def test_what_somebody_is_charged_for_keeps_nobody_out() -> None:
    """Neither strangers' floods nor what viewers ask for: they wait themselves."""
    assert looked(0.9, charged=0.5).has_time(SERVED)


@pytest.mark.parametrize(("more", "fits"), [(-0.01, True), (0.01, False)])
def test_nobody_more_fits_where_all_cores_are_busy(more: float, *, fits: bool) -> None:
    """As with the encoders on a machine that has one."""
    others = 2.0 * CORES_SHARE - 0.21 + more
    assert looked(0.2, process=others).has_time(SERVED) is fits


def test_a_rush_is_over_after_ten_seconds() -> None:
    """What was before counts no more, and at the start there is time."""
    assert looked(0.3, before=1.0).has_time(SERVED)
    assert Headroom(2.0, TurnedClock(), lambda: 0.0).has_time(SERVED)
