"""Bakes every surface of a world into one image (pure).

One image means that a whole view is a single `cv2.remap`. It holds each piece as a mipmap, so that
distant surfaces do not flicker.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

import cv2
import numpy as np

from wax.robot.simulated import paint, pictures

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.robot.simulated.world import Box, World

LEVELS = 4
WALL_PX_PER_M = 96.0
FLOOR_PX_PER_M = 64.0
_SHELF_PX = 4096
_BORDER_PX = 2

WEST, EAST, SOUTH, NORTH = range(4)
"""The faces of a box by the direction they face."""


@dataclass(frozen=True)
class Atlas:
    """The image, and each piece's origin in it as ``[..., level, (u, v)]`` in pixels.

    A piece of level n has ``px_per_m / 2**n`` pixels a metre. Floor and ceiling have north up;
    a wall face is as seen from in front of it, ceiling up. `sides` and `tops` are of each material.

    The image is blue, green, red, alpha, because OpenCV looks up four channels in half the time of
    three. `alpha` is that channel alone: 0 where one sees through a plant.
    """

    image: NDArray[np.uint8]
    alpha: NDArray[np.uint8]
    floor: NDArray[np.float32]
    ceiling: NDArray[np.float32]
    faces: NDArray[np.float32]
    sides: dict[str, NDArray[np.float32]]
    tops: dict[str, NDArray[np.float32]]


@cache
def bake(world: World) -> Atlas:
    """Paint and pack everything; takes some tens of milliseconds."""
    packer = _Packer()
    floor = packer.add(floor_plan(world))
    ceiling = packer.add(_ceiling(world))
    unseen = np.zeros((LEVELS, 2), np.float32)
    faces = []
    for wall in world.walls:
        for side in (WEST, EAST, SOUTH, NORTH):
            painted = _face(world, wall, side)
            faces.append(unseen if painted is None else packer.add(painted))
    names = {b.material for b in world.boxes} | {c.material for c in world.cylinders}
    sides = {name: packer.add(paint.side(name)) for name in sorted(names)}
    tops = {name: packer.add(paint.top(name)) for name in sorted(names)}
    image = packer.image()
    return Atlas(
        image=image,
        alpha=np.ascontiguousarray(image[..., 3]),
        floor=floor,
        ceiling=ceiling,
        faces=np.stack(faces).reshape(-1, 4, LEVELS, 2),
        sides=sides,
        tops=tops,
    )


def level(span: NDArray[np.floating]) -> NDArray[np.intp]:
    """Return the mipmap level whose pixels fit one picture pixel that spans so many of level 0."""
    return np.asarray(np.clip(np.round(np.log2(np.maximum(span, 1e-3))), 0, LEVELS - 1), np.intp)


class _Packer:
    """Put images side by side on shelves."""

    def __init__(self) -> None:
        self._rows: list[list[NDArray[np.uint8]]] = [[]]
        self._x = 0
        self._places: list[tuple[NDArray[np.float32], int, int, int]] = []

    def add(self, image: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Place an image and its mipmap levels; the returned corners are valid after `image()`."""
        if image.shape[2] == 3:
            image = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2BGRA), np.uint8)
        corners = np.zeros((LEVELS, 2), np.float32)
        for level in range(LEVELS):
            if level:
                size = (max(1, image.shape[1] // 2), max(1, image.shape[0] // 2))
                image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
            self._place(image, corners, level)
        return corners

    def _place(self, image: NDArray[np.uint8], corners: NDArray[np.float32], level: int) -> None:
        b = _BORDER_PX
        padded = np.asarray(cv2.copyMakeBorder(image, b, b, b, b, cv2.BORDER_REPLICATE), np.uint8)
        if self._x + padded.shape[1] > _SHELF_PX and self._rows[-1]:
            self._rows.append([])
            self._x = 0
        self._rows[-1].append(padded)
        self._places.append((corners, level, len(self._rows) - 1, self._x))
        self._x += padded.shape[1]

    def image(self) -> NDArray[np.uint8]:
        heights = [max(piece.shape[0] for piece in row) for row in self._rows]
        tops = np.concatenate([[0], np.cumsum(heights)])
        width = max(sum(piece.shape[1] for piece in row) for row in self._rows)
        whole = np.zeros((int(tops[-1]), width, 4), np.uint8)
        for row, top in zip(self._rows, tops, strict=False):
            x = 0
            for piece in row:
                whole[top : top + piece.shape[0], x : x + piece.shape[1]] = piece
                x += piece.shape[1]
        for corners, level, row_index, x in self._places:
            corners[level] = (x + _BORDER_PX - 0.5, tops[row_index] + _BORDER_PX - 0.5)
        return whole


def _face(world: World, wall: Box, side: int) -> NDArray[np.uint8] | None:
    """Paint one face of a wall, None when no room sees it."""
    ppm = WALL_PX_PER_M
    along_y = side in (WEST, EAST)
    low, high = (wall.y0, wall.y1) if along_y else (wall.x0, wall.x1)
    front = {WEST: wall.x0 - 0.07, EAST: wall.x1 + 0.07, SOUTH: wall.y0 - 0.07}.get(
        side, wall.y1 + 0.07
    )
    columns = max(1, round((high - low) * ppm))
    rows = round(world.height * ppm)
    places = low + (np.arange(columns) + 0.5) / ppm
    if side in (WEST, NORTH):
        places = places[::-1]
    rooms = [
        world.room_at(front, float(p)) if along_y else world.room_at(float(p), front)
        for p in places
    ]
    if not any(rooms):
        return None
    image = paint.plain(columns, rows, paint.TRIM)
    starts = [0, *(i for i in range(1, columns) if rooms[i] is not rooms[i - 1]), columns]
    for start, end in pairwise(starts):
        room = rooms[start]
        if room is not None:
            piece = paint.wall(room.wall, end - start, rows, ppm)
            image[:, start:end] = piece * _corner_shade(end - start)[None, :, None]
    _frame_doorways(world, wall, side, image)
    for decal in world.decals:
        at, across = (decal.y, decal.x) if along_y else (decal.x, decal.y)
        plane = front - 0.07 if side in (EAST, NORTH) else front + 0.07
        if abs(across - plane) > 0.03 or not low < at < high:
            continue
        middle = (high - at if side in (WEST, NORTH) else at - low) * ppm
        width, height = round(decal.width * ppm), round(decal.height * ppm)
        x, y = round(middle - width / 2), round((world.height - decal.z) * ppm - height / 2)
        image[y : y + height, x : x + width] = pictures.picture(decal.picture, width, height)
    return image


def _corner_shade(columns: int) -> NDArray[np.float64]:
    """Return the shading that makes walls a little darker towards the room's corners."""
    x = np.arange(columns)
    near_m = np.minimum(x, columns - 1 - x) / WALL_PX_PER_M
    return np.asarray(0.88 + 0.12 * np.minimum(1.0, near_m / 0.3))


def _frame_doorways(world: World, wall: Box, side: int, image: NDArray[np.uint8]) -> None:
    """Paint the door frame where a wall ends at a doorway, and the wall's whole end face."""
    band = int(0.1 * WALL_PX_PER_M)
    top = round(
        (world.height - min(b.z0 for b in world.boxes if b.material == "lintel") - 0.1)
        * WALL_PX_PER_M
    )
    for lintel in (box for box in world.boxes if box.material == "lintel"):
        if _meet(lintel.y0, wall.y0) and _meet(lintel.y1, wall.y1):
            at_low, at_high = _meet(lintel.x1, wall.x0), _meet(lintel.x0, wall.x1)
            ends, left_is_low = (WEST, EAST), side == SOUTH
        elif _meet(lintel.x0, wall.x0) and _meet(lintel.x1, wall.x1):
            at_low, at_high = _meet(lintel.y1, wall.y0), _meet(lintel.y0, wall.y1)
            ends, left_is_low = (SOUTH, NORTH), side == EAST
        else:
            continue
        if side in ends:
            if (at_low and side == ends[0]) or (at_high and side == ends[1]):
                image[top:] = paint.TRIM
        elif at_low or at_high:
            if at_low == left_is_low:
                image[top:, :band] = paint.TRIM
            else:
                image[top:, -band:] = paint.TRIM


def _meet(one: float, other: float) -> bool:
    return abs(one - other) < 1e-6


def floor_plan(world: World) -> NDArray[np.uint8]:
    """Paint the floor from above, north up, at `FLOOR_PX_PER_M`, with shadows under objects."""
    ppm = FLOOR_PX_PER_M
    image = paint.plain(round(world.width * ppm), round(world.depth * ppm), paint.TRIM)
    for room in world.rooms:
        area = _area(world, room.x0, room.y0, room.x1, room.y1)
        height, width = image[area].shape[:2]
        image[area] = paint.floor(room.floor, width, height, ppm)
    for rug in world.rugs:
        area = _area(world, rug.x0, rug.y0, rug.x1, rug.y1)
        height, width = image[area].shape[:2]
        image[area] = pictures.rug(rug.picture, width, height, image[area])
    free = np.full(image.shape[:2], 255, np.uint8)
    standing = (*world.walls, *(box for box in world.boxes if box.z0 < 0.1))
    for box in standing:
        free[_area(world, box.x0, box.y0, box.x1, box.y1)] = 0
    for tube in world.cylinders:
        if tube.z0 < 0.1:
            middle = (round(tube.x * ppm), round((world.depth - tube.y) * ppm))
            cv2.circle(free, middle, round(tube.radius * ppm), 0, -1)
    near = np.asarray(cv2.distanceTransform(free, cv2.DIST_L2, 3)) / ppm
    shade = 0.62 + 0.38 * np.sqrt(np.minimum(1.0, near / 0.4))
    return np.asarray(image * shade[..., None], np.uint8)


def _ceiling(world: World) -> NDArray[np.uint8]:
    ppm = FLOOR_PX_PER_M
    image = paint.plain(round(world.width * ppm), round(world.depth * ppm), (214, 220, 222))
    for room in world.rooms:
        middle = (
            round((room.x0 + room.x1) / 2 * ppm),
            round((world.depth - (room.y0 + room.y1) / 2) * ppm),
        )
        cv2.circle(image, middle, round(0.3 * ppm), (160, 180, 190), -1, cv2.LINE_AA)
        cv2.circle(image, middle, round(0.26 * ppm), (226, 250, 255), -1, cv2.LINE_AA)
    return image


def _area(world: World, x0: float, y0: float, x1: float, y1: float) -> tuple[slice, slice]:
    ppm = FLOOR_PX_PER_M
    rows = (max(0, round((world.depth - y1) * ppm)), max(0, round((world.depth - y0) * ppm)))
    return slice(*rows), slice(max(0, round(x0 * ppm)), max(0, round(x1 * ppm)))
