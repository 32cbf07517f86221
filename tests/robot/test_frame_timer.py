"""A steady rate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.robot.simulated.frame_timer import FrameTimer

if TYPE_CHECKING:
    from tests.robot.conftest import FakeClock


def test_beats_do_not_drift(clock: FakeClock) -> None:
    """Beats are a period apart by the clock, whatever is done between them."""
    pacer = FrameTimer(0.02, clock, clock.wait)
    beats = []
    for work_s in (0.0, 0.015, 0.001, 0.03, 0.0):
        beats.append(pacer.beat())
        clock.time_s += work_s
    assert beats == pytest.approx([1000.02, 1000.04, 1000.06, 1000.08, 1000.10])
    assert pacer.beat() == pytest.approx(1000.12)
    assert clock.time_s == pytest.approx(1000.12)


def test_a_long_pause_is_not_made_up_for(clock: FakeClock) -> None:
    """After a sleep of the machine the beat starts over instead of catching up."""
    pacer = FrameTimer(0.02, clock, clock.wait)
    pacer.beat()
    clock.time_s += 10.0
    late_s = clock.time_s
    assert pacer.beat() == late_s
    assert pacer.beat() == pytest.approx(late_s + 0.02)


def test_a_wait_can_end_early(clock: FakeClock) -> None:
    """A wait that is ended early ends the beat at once."""
    pacer = FrameTimer(1.0, clock, lambda _: True)
    pacer.beat()
    assert clock.time_s == 1000.0
