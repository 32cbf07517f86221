"""A sound at a place in the flat, and how the robot's ears hear it there (pure)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from wax.capture.source import BLOCK_SAMPLES
from wax.robot.simulated.ears import Ears

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.driver.interface import Pose
    from wax.robot.simulated.simulation import Senses
    from wax.robot.simulated.world import World

NEAREST_M: Final = 0.35
WALL_GAIN: Final = 0.35
BEHIND_GAIN: Final = 0.4
_SMOOTHING: Final = 0.134
"""The fraction of a loudness change made per block, so that passing a doorway makes no click."""


class Emitter(Protocol):
    """A sound source at a place."""

    @property
    def place(self) -> tuple[float, float]:
        """Where it is, in metres."""
        ...

    def play(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the next `count` samples, and the same as they come through a wall.

        1 is full scale at one metre.
        """
        ...


@dataclass(frozen=True, slots=True)
class SoundReach:
    """How sound reaches the head: how loud, through how many walls, and from where.

    A `gain` of 1 is one metre in front; `bearing_rad` is from straight ahead to the left.
    """

    gain: float
    walls: int
    bearing_rad: float


def reach(world: World, place: tuple[float, float], pose: Pose, ear_rad: float) -> SoundReach:
    """Return how sound from `place` reaches a head at `pose` that looks towards `ear_rad`.

    It falls by 6 dB for each doubling of the distance and by 9 dB for each wall, and is 8 dB
    quieter from behind, so that an operator who turns hears whether it is in front.
    """
    east, north = place[0] - pose.x_m, place[1] - pose.y_m
    walls = world.walls_between(pose.x_m, pose.y_m, *place)
    bearing_rad = math.remainder(math.atan2(north, east) - ear_rad, math.tau)
    facing = (1.0 + BEHIND_GAIN) / 2.0 + (1.0 - BEHIND_GAIN) / 2.0 * math.cos(bearing_rad)
    gain = facing * WALL_GAIN**walls / max(NEAREST_M, math.hypot(east, north))
    return SoundReach(gain, walls, bearing_rad)


class PlacedSound:
    """What both ears hear of one emitter; each block joins the last without a click."""

    def __init__(self, emitter: Emitter, world: World) -> None:
        self._emitter = emitter
        self._world = world
        self._ears = Ears()
        self._gains: tuple[float, float] | None = None

    def heard(self, senses: Senses) -> NDArray[np.float64]:
        """Return the next `BLOCK_SAMPLES` as ``(n, 2)``, the left ear first."""
        ear_rad = senses.pose.heading_rad + senses.pan_rad
        now = reach(self._world, self._emitter.place, senses.pose, ear_rad)
        through = 1.0 - 0.25**now.walls
        wanted = (now.gain * (1.0 - through), now.gain * through)
        old = self._gains or wanted
        new = tuple(a + _SMOOTHING * (b - a) for a, b in zip(old, wanted, strict=True))
        self._gains = (new[0], new[1])
        clear, muffled = self._emitter.play(BLOCK_SAMPLES)
        glide = np.arange(BLOCK_SAMPLES) / BLOCK_SAMPLES
        sound = clear * (old[0] + (new[0] - old[0]) * glide)
        sound = sound + muffled * (old[1] + (new[1] - old[1]) * glide)
        return self._ears.hear(sound, now.bearing_rad)
