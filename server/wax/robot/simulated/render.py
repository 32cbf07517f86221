"""Draw the robot's view (pure): one ray per picture column, all colours by one `cv2.remap`.

Floor and ceiling are placed first, walls over them, then furniture from far to near. Depths are
measured along the direction of view, so straight walls stay straight.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from wax.robot.simulated import atlas
from wax.robot.simulated.lookup import Lookup, Strip
from wax.robot.simulated.props import Props
from wax.robot.simulated.view import EYE_HEIGHT_M, FAR_M, NEAR_M, View, enter_boxes, face_of, fade

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.driver.interface import Pose
    from wax.robot.simulated.world import World


class Renderer:
    """Draws pictures of one size; keeps its buffers, so it belongs to one thread."""

    def __init__(self, world: World, width: int, height: int) -> None:
        self._world = world
        self._width, self._height = width, height
        self._atlas = atlas.bake(world)
        self._props = Props(world, self._atlas)
        self._walls = np.array([(b.x0, b.y0, b.x1, b.y1) for b in world.walls], np.float32)
        self._lookup = Lookup(self._atlas, width, height)
        self._drawn: tuple[Pose, float] | None = None
        self._picture = np.empty((0, 0, 3), np.uint8)

    def draw(self, pose: Pose, pan_rad: float = 0.0) -> NDArray[np.uint8]:
        """Return the view from `pose`, shape ``(height, width, 3)``, blue, green, red.

        The array is overwritten by the next call. Nothing moves but the robot, so from where it has
        just been drawn the picture is the same.
        """
        if self._drawn != (pose, pan_rad):
            self._drawn = (pose, pan_rad)
            view = View(pose, pan_rad, self._width, self._height)
            walls = self._wall_strip(view)
            self._map(view, slice(0, _row(walls.top.max(), self._height)))
            self._map(view, slice(_row(walls.bottom.min() - 1.0, self._height), self._height))
            self._lookup.put(walls)
            self._props.put(self._lookup, view, self._depth)
            self._picture = self._lookup.picture()
        return self._picture

    def _map(self, view: View, cut: slice) -> None:
        """Map these rows to the ceiling, or below the horizon to the floor."""
        below = self._lookup.rows[cut, 0] - view.horizon_px
        drop = np.where(below > 0.0, EYE_HEIGHT_M, EYE_HEIGHT_M - self._world.height)
        depth = np.minimum(view.focal_px * drop / np.where(below == 0.0, 1e-6, below), FAR_M)
        ppm = atlas.FLOOR_PX_PER_M
        # How many texture pixels one picture pixel spans, between across and along the view.
        span = ppm * depth / view.focal_px * np.sqrt(2.0 * depth / np.abs(drop))
        level = atlas.level(span)
        scale = ppm / 2.0**level
        corner = np.where(
            (below > 0.0)[:, None], self._atlas.floor[level], self._atlas.ceiling[level]
        )
        reach = (depth * scale).astype(np.float32)[:, None]
        start_u = (corner[:, 0] + view.eye_x * scale).astype(np.float32)[:, None]
        start_v = (corner[:, 1] + (self._world.depth - view.eye_y) * scale).astype(np.float32)
        u, v = self._lookup.u[cut], self._lookup.v[cut]
        np.multiply(reach, view.x[None, :], out=u)
        u += start_u
        np.multiply(reach, -view.y[None, :], out=v)
        v += start_v[:, None]
        self._lookup.shade[cut] = (255.0 * fade(depth)).astype(np.uint8)[:, None]

    def _wall_strip(self, view: View) -> Strip:
        self._depth, nearest, side, along = _first_wall(self._walls, view)
        ppm = atlas.WALL_PX_PER_M
        level = atlas.level(ppm * self._depth / view.focal_px)
        corner = self._atlas.faces[nearest, side, level]
        scale = (ppm / 2.0**level).astype(np.float32)
        top, bottom = view.row(self._world.height, self._depth), view.row(0.0, self._depth)
        light = np.array([0.86, 0.9, 1.0, 0.95], np.float32)[side]
        return Strip(
            first=0,
            top=top,
            bottom=bottom,
            seen=np.ones(self._width, np.bool_),
            u=corner[:, 0] + along * scale,
            v=corner[:, 1],
            slope=np.float32(self._world.height) * scale / (bottom - top),
            shade=fade(self._depth) * light,
        )


def _row(row: float, height: int) -> int:
    """Return the first whole row at or below `row`, within the picture."""
    return min(height, max(0, math.ceil(row)))


def _first_wall(
    walls: NDArray[np.float32], view: View
) -> tuple[NDArray[np.float32], NDArray[np.intp], NDArray[np.intp], NDArray[np.float32]]:
    enter, leave, by_x = enter_boxes(walls, view)
    seen = np.where((enter < leave) & (enter > NEAR_M), enter, np.float32(FAR_M))
    nearest = np.argmin(seen, axis=0)
    columns = np.arange(view.width)
    depth = seen[nearest, columns]
    side, along = face_of(walls[nearest], by_x[nearest, columns], depth, view)
    return depth, nearest, side, along
