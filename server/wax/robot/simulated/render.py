"""Draw the robot's view (pure): one ray per picture column, textures by `cv2.remap`.

Walls, floor and ceiling are one pass over the whole picture; furniture is painted over it from
far to near. Depths are measured along the direction of view, so straight walls stay straight.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import cv2
import numpy as np

from wax.robot.simulated import atlas
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
        self._props = Props(world)
        self._walls = np.array([(b.x0, b.y0, b.x1, b.y1) for b in world.walls], np.float32)
        self._rows = (np.arange(height, dtype=np.float32) + 0.5)[:, None]
        self._u = np.empty((height, width), np.float32)
        self._v = np.empty((height, width), np.float32)
        self._shade = np.empty((height, width), np.uint8)
        self._frame = np.empty((height, width, 3), np.uint8)

    def draw(self, pose: Pose, pan_rad: float = 0.0) -> NDArray[np.uint8]:
        """Return the view from `pose`, shape ``(height, width, 3)``, blue, green, red.

        The array is overwritten by the next call.
        """
        view = View(pose, pan_rad, self._width, self._height)
        self._map_floor_and_ceiling(view)
        wall_depth = self._map_walls(view)
        cv2.remap(self._atlas.image, self._u, self._v, cv2.INTER_LINEAR, dst=self._frame)
        shade = cv2.cvtColor(self._shade, cv2.COLOR_GRAY2BGR)
        cv2.multiply(self._frame, shade, dst=self._frame, scale=1.0 / 255.0)
        self._props.paint(self._frame, view, wall_depth)
        return self._frame

    def _map_floor_and_ceiling(self, view: View) -> None:
        below = self._rows[:, 0] - view.horizon_px
        drop = np.where(below > 0.0, EYE_HEIGHT_M, EYE_HEIGHT_M - self._world.height)
        depth = np.minimum(view.focal_px * drop / np.where(below == 0.0, 1e-6, below), FAR_M)
        ppm = atlas.FLOOR_PX_PER_M
        # How many texture pixels one picture pixel spans, between across and along the view.
        span = ppm * depth / view.focal_px * np.sqrt(2.0 * depth / np.abs(drop))
        level = np.clip(np.round(np.log2(np.maximum(span, 1e-3))), 0, atlas.LEVELS - 1).astype(int)
        scale = ppm / 2.0**level
        corner = np.where(
            (below > 0.0)[:, None], self._atlas.floor[level], self._atlas.ceiling[level]
        )
        reach = (depth * scale).astype(np.float32)[:, None]
        start_u = (corner[:, 0] + view.eye_x * scale).astype(np.float32)[:, None]
        start_v = (corner[:, 1] + (self._world.depth - view.eye_y) * scale).astype(np.float32)
        np.multiply(reach, view.x[None, :], out=self._u)
        self._u += start_u
        np.multiply(reach, -view.y[None, :], out=self._v)
        self._v += start_v[:, None]
        self._shade[:] = (255.0 * fade(depth)).astype(np.uint8)[:, None]

    def _map_walls(self, view: View) -> NDArray[np.float32]:
        depth, nearest, side, along = _first_wall(self._walls, view)
        ppm = atlas.WALL_PX_PER_M
        span = ppm * depth / view.focal_px
        level = np.clip(np.round(np.log2(np.maximum(span, 1e-3))), 0, atlas.LEVELS - 1).astype(int)
        corner = self._atlas.faces[nearest, side, level]
        scale = (ppm / 2.0**level).astype(np.float32)
        u = corner[:, 0] + along * scale
        top, bottom = view.row(self._world.height, depth), view.row(0.0, depth)
        slope = np.float32(self._world.height) * scale / (bottom - top)
        light = np.array([0.86, 0.9, 1.0, 0.95], np.float32)[side]
        shade = (255.0 * fade(depth) * light).astype(np.uint8)
        first = max(0, math.floor(float(top.min())))
        last = min(self._height, math.ceil(float(bottom.max())))
        rows = self._rows[first:last]
        mask = (rows >= top) & (rows < bottom)
        np.copyto(self._u[first:last], u, where=mask)
        np.copyto(self._v[first:last], (rows - top) * slope + corner[:, 1], where=mask)
        np.copyto(self._shade[first:last], shade, where=mask)
        return depth


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
