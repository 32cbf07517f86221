"""The parts of a world (pure): upright boxes and cylinders in metres, x to the east, y north.

Everything that is an obstacle, is visible or muffles sound is one of these two shapes. An object
above the robot's height, such as a lintel or a table top, is visible but not an obstacle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.driver.interface import Pose


@dataclass(frozen=True, slots=True)
class Box:
    """A box along the axes, from `z0` to `z1` above the floor; `material` names its look."""

    x0: float
    y0: float
    x1: float
    y1: float
    z0: float
    z1: float
    material: str


@dataclass(frozen=True, slots=True)
class Cylinder:
    """An upright cylinder; a `leafy` one is drawn as a flat picture and is no obstacle."""

    x: float
    y: float
    radius: float
    z0: float
    z1: float
    material: str
    leafy: bool = False


@dataclass(frozen=True, slots=True)
class FlatRoom:
    """A rectangle of floor; `wall` and `floor` name their looks."""

    name: str
    x0: float
    y0: float
    x1: float
    y1: float
    wall: str
    floor: str

    def holds(self, x: float, y: float) -> bool:
        return self.x0 <= x < self.x1 and self.y0 <= y < self.y1


@dataclass(frozen=True, slots=True)
class Decal:
    """A picture on a wall: its middle (x, y, z), the direction it faces, and its size."""

    x: float
    y: float
    z: float
    width: float
    height: float
    picture: str


@dataclass(frozen=True, slots=True)
class Rug:
    """A picture on the floor."""

    x0: float
    y0: float
    x1: float
    y1: float
    picture: str


@dataclass(frozen=True, slots=True)
class Dweller:
    """A person at a place; their `name` selects their recorded answers."""

    name: str
    x: float
    y: float


@dataclass(frozen=True)
class World:
    """A place. `walls` reach from floor to ceiling; `radio` is where its loudspeaker is.

    The visible shapes of the `people` are among the `cylinders`.
    """

    width: float
    depth: float
    height: float
    rooms: tuple[FlatRoom, ...]
    walls: tuple[Box, ...]
    boxes: tuple[Box, ...]
    cylinders: tuple[Cylinder, ...]
    decals: tuple[Decal, ...]
    rugs: tuple[Rug, ...]
    radio: tuple[float, float]
    people: tuple[Dweller, ...]
    start: Pose
    robot_height: float

    def room_at(self, x: float, y: float) -> FlatRoom | None:
        return next((room for room in self.rooms if room.holds(x, y)), None)

    def nearest_surface(self, x: float, y: float) -> tuple[float, float, float]:
        """Find what stands nearest: its distance in m and the unit vector away from it.

        The distance is negative inside, where the vector is the shortest way out.
        """
        boxes, rounds = self._solid_boxes, self._solid_rounds
        near_x = np.clip(x, boxes[:, 0], boxes[:, 2])
        near_y = np.clip(y, boxes[:, 1], boxes[:, 3])
        to_boxes = np.hypot(x - near_x, y - near_y)
        to_rounds = np.hypot(x - rounds[:, 0], y - rounds[:, 1]) - rounds[:, 2]
        box = int(np.argmin(to_boxes))
        ball = int(np.argmin(to_rounds))
        if to_rounds[ball] < to_boxes[box]:
            return self._away_from_round(x, y, ball)
        distance = float(to_boxes[box])
        if distance > 0.0:
            return distance, float(x - near_x[box]) / distance, float(y - near_y[box]) / distance
        x0, y0, x1, y1 = (float(edge) for edge in boxes[box])
        return max(
            (x0 - x, -1.0, 0.0),
            (x - x1, 1.0, 0.0),
            (y0 - y, 0.0, -1.0),
            (y - y1, 0.0, 1.0),
        )

    def walls_between(self, x: float, y: float, to_x: float, to_y: float) -> int:
        """Count the walls that a straight line passes through."""
        walls = self._wall_edges
        start, way = np.array([x, y]), np.array([to_x - x, to_y - y])
        way = np.where(np.abs(way) < 1e-9, 1e-9, way)
        first = (walls[:, :2] - start) / way
        second = (walls[:, 2:] - start) / way
        enter = np.minimum(first, second).max(axis=1)
        leave = np.maximum(first, second).min(axis=1)
        return int(np.count_nonzero((enter < leave) & (leave > 0.0) & (enter < 1.0)))

    def _away_from_round(self, x: float, y: float, index: int) -> tuple[float, float, float]:
        centre_x, centre_y, radius = (float(part) for part in self._solid_rounds[index])
        apart = math.hypot(x - centre_x, y - centre_y)
        if apart == 0.0:
            return -radius, 1.0, 0.0
        return apart - radius, (x - centre_x) / apart, (y - centre_y) / apart

    @cached_property
    def _wall_edges(self) -> NDArray[np.float64]:
        return np.array([(b.x0, b.y0, b.x1, b.y1) for b in self.walls]).reshape(-1, 4)

    @cached_property
    def _solid_boxes(self) -> NDArray[np.float64]:
        boxes = (*self.walls, *(b for b in self.boxes if b.z0 < self.robot_height))
        return np.array([(b.x0, b.y0, b.x1, b.y1) for b in boxes]).reshape(-1, 4)

    @cached_property
    def _solid_rounds(self) -> NDArray[np.float64]:
        hard = (c for c in self.cylinders if c.z0 < self.robot_height and not c.leafy)
        rounds = [(c.x, c.y, c.radius) for c in hard]
        return np.array(rounds or [(1e9, 1e9, 0.0)]).reshape(-1, 3)
