"""The rays of a picture, and the boxes they meet (pure)."""

from __future__ import annotations

import copy
import math
from typing import TYPE_CHECKING

import numpy as np

from wax.robot.simulated import atlas

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.driver.interface import Pose

FIELD_OF_VIEW_RAD = math.radians(76.0)
EYE_HEIGHT_M = 0.5
HORIZON = 0.46
"""Where the horizon is, as a share of the picture's height: a little more floor than ceiling."""

NEAR_M = 0.03
FAR_M = 30.0


class View:
    """The rays of one picture: column `c` looks along ``(x[c], y[c])`` for each metre of depth."""

    def __init__(self, pose: Pose, pan_rad: float, width: int, height: int) -> None:
        heading = pose.heading_rad + pan_rad
        self.width, self.height = width, height
        self.focal_px = width / 2.0 / math.tan(FIELD_OF_VIEW_RAD / 2.0)
        self.horizon_px = height * HORIZON
        self.eye_x, self.eye_y = pose.x_m, pose.y_m
        self.ahead_x, self.ahead_y = math.cos(heading), math.sin(heading)
        aside = ((np.arange(width) + 0.5 - width / 2.0) / self.focal_px).astype(np.float32)
        self.aside = aside
        self.x = _nonzero(np.float32(self.ahead_x) + aside * np.float32(self.ahead_y))
        self.y = _nonzero(np.float32(self.ahead_y) - aside * np.float32(self.ahead_x))

    def row(self, z: float, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the picture rows of points `z` above the floor at these depths."""
        return np.asarray(self.horizon_px + self.focal_px * (EYE_HEIGHT_M - z) / depth, np.float32)

    def columns(self, cut: slice) -> View:
        """Return the same view with only these columns."""
        part = copy.copy(self)
        part.aside, part.x, part.y = self.aside[cut], self.x[cut], self.y[cut]
        part.width = len(part.x)
        return part


def fade(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the brightness at these depths: 1 at the eye, about 0.65 across the whole flat."""
    return np.asarray(1.0 / (1.0 + 0.05 * np.maximum(depth, 0.0)), np.float32)


def enter_boxes(
    edges: NDArray[np.float32], view: View
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Return where each ray (axis 1) enters and leaves each box (axis 0), and if by an x face."""
    x0, x1 = (edges[:, [0, 2]].T[..., None] - np.float32(view.eye_x)) / view.x
    y0, y1 = (edges[:, [1, 3]].T[..., None] - np.float32(view.eye_y)) / view.y
    enter_x, enter_y = np.minimum(x0, x1), np.minimum(y0, y1)
    leave = np.minimum(np.maximum(x0, x1), np.maximum(y0, y1))
    return np.maximum(enter_x, enter_y), leave, enter_x > enter_y


def face_of(
    edges: NDArray[np.float32], by_x: NDArray[np.bool_], depth: NDArray[np.float32], view: View
) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Return which face each ray hits, and how far from its left end; `edges` has one per ray."""
    x = np.float32(view.eye_x) + depth * view.x
    y = np.float32(view.eye_y) + depth * view.y
    side = np.where(
        by_x,
        np.where(view.x > 0, atlas.WEST, atlas.EAST),
        np.where(view.y > 0, atlas.SOUTH, atlas.NORTH),
    )
    along = np.choose(side, [edges[:, 3] - y, y - edges[:, 1], x - edges[:, 0], edges[:, 2] - x])
    return side, np.asarray(along, np.float32)


def _nonzero(rays: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.where(np.abs(rays) < 1e-6, np.float32(1e-6), rays)
