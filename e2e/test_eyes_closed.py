"""The radio, found with eyes closed: by what two ears hear through Opus, and nothing else."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from e2e.delay.voice.direction import SHARE, WITHIN_DEG, errors, stereo_forms
from e2e.harness.direction import lateral_deg
from e2e.harness.listener import Listener
from wax.config.settings import RobotSettings
from wax.driver.interface import STANDSTILL, Pose, Twist
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.hearing import BLOCK_S
from wax.robot.simulated.simulation import Simulation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.congestion.allocation import SoundForm

THINNEST = stereo_forms()[-1]
NEAR_M = 0.7
LISTENS_BLOCKS = 40
DECIDES_BLOCKS = 20
FACES_DEG = 25.0
TURN = 1

STARTS = {
    "where it starts": furnished_flat().start,
    "with its back to it": Pose(1.1, 0.9, math.radians(-150.0)),
    "in the corner, to its left": Pose(4.3, 1.5, math.radians(10.0)),
    "beyond the table, to its right": Pose(2.6, 2.9, math.radians(170.0)),
}


def steer(heard: NDArray[np.int16]) -> Twist:
    """Turn to the side that is heard first; go where both ears hear the same."""
    side_deg = lateral_deg(heard)
    if side_deg is None:
        return STANDSTILL
    ahead_mps = 0.3 if abs(side_deg) < FACES_DEG else 0.0
    return Twist(ahead_mps, max(-1.2, min(1.2, math.radians(side_deg) * 1.5)))


def drive(start: Pose, within_s: float, form: SoundForm = THINNEST) -> tuple[float, float]:
    """Drive by ear; return how near it came, in metres, and after how many seconds."""
    world = replace(furnished_flat(), start=start)
    simulation = Simulation(RobotSettings(), world)
    simulation.start(0.0)
    listener = Listener(world, form)
    heard: deque[NDArray[np.int16]] = deque(maxlen=LISTENS_BLOCKS)
    nearest_m, twist = math.inf, STANDSTILL
    for number in range(1, round(within_s / BLOCK_S)):
        now_s = number * BLOCK_S
        senses = simulation.advance(now_s)
        heard.append(listener.hear(senses))
        if number % DECIDES_BLOCKS == 0 and len(heard) == LISTENS_BLOCKS:
            twist = steer(np.concatenate(heard))
        if number % 10 == 0:
            simulation.apply(twist, TURN, now_s)
        x, y = world.radio
        nearest_m = min(nearest_m, math.hypot(x - senses.pose.x_m, y - senses.pose.y_m))
        if nearest_m < NEAR_M:
            return nearest_m, now_s
    return nearest_m, within_s


@pytest.mark.parametrize(
    "where",
    [
        pytest.param(where, marks=[] if where == "where it starts" else pytest.mark.full)
        for where in STARTS
    ],
)
def test_the_radio_is_found_with_eyes_closed(where: str) -> None:
    """Steered by the difference between the ears alone, the robot comes to the radio."""
    nearest_m, took_s = drive(STARTS[where], within_s=60.0)
    assert nearest_m < NEAR_M, f"{nearest_m:.2f} m after {took_s:.0f} s"


@pytest.mark.full
def test_in_mono_it_is_not_found() -> None:
    """With the same in both ears nothing says where to turn: it is by two that it is found."""
    nearest_m, _ = drive(STARTS["with its back to it"], 20.0, replace(THINNEST, channels=1))
    assert nearest_m > 2.0


@pytest.mark.full
def test_the_side_and_the_direction_are_heard() -> None:
    """In the thinnest stereo: the right side always, the direction to 20° in nine of ten."""
    errors_deg, wrong = errors(THINNEST, 20, seed=7)
    assert wrong == 0
    assert sum(error <= WITHIN_DEG for error in errors_deg) >= SHARE * len(errors_deg)
