"""The external view of the simulated robot: the flat without its ceiling from above, north up."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

from wax.capture.letterbox import fit_bgr
from wax.robot.simulated import atlas, paint

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.driver.interface import Pose
    from wax.robot.simulated.world import World

_WALL: Final = (150, 158, 162)
_BODY: Final = (40, 40, 48)
_HEAD: Final = (60, 200, 250)
_BODY_M: Final = 0.2
"""The robot's radius."""
_SIGHT_M: Final = 0.55
"""The length of the wedge that shows where the head looks."""
_SIGHT_RAD: Final = math.radians(30.0)
_HEADROOM_M: Final = 2.0
"""Higher objects, such as lintels, are left out, because they would hide the floor."""
_SUBPIXEL_BITS: Final = 4


class ExternalView:
    """Draws the flat from above in pictures of one size."""

    def __init__(self, world: World, width: int, height: int) -> None:
        self._world = world
        self._width, self._height = width, height
        self._plan = plan(world)

    def draw(self, pose: Pose, pan_rad: float) -> NDArray[np.uint8]:
        """Return the flat with the robot in it, ``(height, width, 3)``, blue, green, red."""
        image = self._plan.copy()
        mark(image, self._world, pose, pan_rad)
        return fit_bgr(image, self._width, self._height)


def plan(world: World) -> NDArray[np.uint8]:
    """Paint the flat and all that stands in it, ``(height, width, 3)``, blue, green, red."""
    image = atlas.floor_plan(world)
    ppm = atlas.FLOOR_PX_PER_M
    low = [box for box in world.boxes if box.z0 < _HEADROOM_M]
    for box in (*sorted(low, key=lambda box: box.z1), *world.walls):
        tone = _WALL if box in world.walls else paint.colour(box.material)
        corner = (round(box.x0 * ppm), round((world.depth - box.y1) * ppm))
        other = (round(box.x1 * ppm), round((world.depth - box.y0) * ppm))
        cv2.rectangle(image, corner, other, tone, cv2.FILLED)
    for tube in world.cylinders:
        middle = (round(tube.x * ppm), round((world.depth - tube.y) * ppm))
        tone = paint.colour(tube.material)
        cv2.circle(image, middle, round(tube.radius * ppm), tone, cv2.FILLED, cv2.LINE_AA)
    return image


def mark(image: NDArray[np.uint8], world: World, pose: Pose, pan_rad: float) -> None:
    """Paint the robot where it is: its body, and a wedge where its head looks."""
    x, y = pose.x_m, world.depth - pose.y_m
    looks = pose.heading_rad + pan_rad
    wedge = [(x, y)]
    for side in (-_SIGHT_RAD, _SIGHT_RAD):
        at = looks + side
        wedge.append((x + _SIGHT_M * math.cos(at), y - _SIGHT_M * math.sin(at)))
    scale = atlas.FLOOR_PX_PER_M * 2**_SUBPIXEL_BITS
    corners = np.round(np.array(wedge) * scale).astype(np.int32)
    cv2.fillConvexPoly(image, corners, _HEAD, cv2.LINE_AA, _SUBPIXEL_BITS)
    middle = (round(x * scale), round(y * scale))
    ahead = (
        round((x + _BODY_M * math.cos(pose.heading_rad)) * scale),
        round((y - _BODY_M * math.sin(pose.heading_rad)) * scale),
    )
    radius = round(_BODY_M * scale)
    cv2.circle(image, middle, radius, _BODY, cv2.FILLED, cv2.LINE_AA, _SUBPIXEL_BITS)
    cv2.line(image, middle, ahead, (255, 255, 255), 3, cv2.LINE_AA, _SUBPIXEL_BITS)
