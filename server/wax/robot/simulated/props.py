"""Paints furniture, doors, pillars and plants over the walls, from far to near (pure)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from wax.robot.simulated import paint
from wax.robot.simulated import view as sight

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.robot.simulated.view import View
    from wax.robot.simulated.world import Cylinder, World

_TEXTURE_LEVELS = 4


@dataclass(frozen=True, slots=True)
class _Patch:
    """Painted in columns from `first`: rows `top` to `bottom` of each column, where `seen`.

    `u` is the share of the texture's width, None for a plain face. The patch with the largest
    `order` is painted first.
    """

    order: float
    first: int
    top: NDArray[np.float32]
    bottom: NDArray[np.float32]
    seen: NDArray[np.bool_]
    shade: NDArray[np.float32]
    material: str
    u: NDArray[np.float32] | None


class Props:
    """Everything in a world except its walls."""

    def __init__(self, world: World) -> None:
        self._boxes = world.boxes
        self._cylinders = world.cylinders
        edges = [(b.x0, b.y0, b.x1, b.y1) for b in world.boxes]
        self._edges = np.array(edges, np.float32).reshape(-1, 4)
        names = {b.material for b in world.boxes} | {c.material for c in world.cylinders}
        self._sides = {name: _halves(paint.side(name)) for name in names}
        leaf_image, leaf_mask = paint.leaves()
        self._leaves, self._leaf_masks = _halves(leaf_image), _halves(leaf_mask)

    def paint(self, frame: NDArray[np.uint8], view: View, wall_depth: NDArray[np.float32]) -> None:
        """Paint what `view` shows of it into `frame`; nearer walls hide it."""
        patches = self._box_patches(view, wall_depth)
        for tube in self._cylinders:
            patches += _cylinder_patches(tube, view, wall_depth)
        for patch in sorted(patches, key=lambda patch: -patch.order):
            self._paint(frame, patch)

    def _box_patches(self, view: View, wall_depth: NDArray[np.float32]) -> list[_Patch]:
        ahead = _ahead(self._edges, view)
        kept = np.flatnonzero(ahead)
        if not kept.size:
            return []
        enter, leave, by_x = sight.enter_boxes(self._edges[kept], view)
        hit = (np.maximum(enter, sight.NEAR_M) < leave) & (enter < wall_depth)
        patches = []
        for number in np.flatnonzero(hit.any(axis=1)):
            columns = np.flatnonzero(hit[number])
            cut = slice(int(columns[0]), int(columns[-1]) + 1)
            patches += self._box_patch(
                int(kept[number]),
                view.columns(cut),
                cut.start,
                (enter[number, cut], np.minimum(leave[number, cut], wall_depth[cut])),
                (hit[number, cut], by_x[number, cut]),
            )
        return patches

    def _box_patch(
        self,
        index: int,
        view: View,
        first: int,
        depths: tuple[NDArray[np.float32], NDArray[np.float32]],
        hits: tuple[NDArray[np.bool_], NDArray[np.bool_]],
    ) -> list[_Patch]:
        box = self._boxes[index]
        (enter, leave), (hit, by_x) = depths, hits
        near = np.maximum(enter, np.float32(sight.NEAR_M))
        patches = []
        outside = hit & (enter > sight.NEAR_M)
        if outside.any():
            edges = np.broadcast_to(self._edges[index], (len(near), 4))
            side, along = sight.face_of(edges, by_x, near, view)
            length = np.where(by_x, box.y1 - box.y0, box.x1 - box.x0)
            light = np.array([0.82, 0.86, 1.0, 0.92], np.float32)[side]
            patches.append(
                _Patch(
                    order=float(near[outside].min()),
                    first=first,
                    top=view.row(box.z1, near),
                    bottom=view.row(box.z0, near),
                    seen=outside,
                    shade=sight.fade(near) * light,
                    material=box.material,
                    u=np.asarray(along / length, np.float32),
                )
            )
        above = box.z1 < sight.EYE_HEIGHT_M
        if above or box.z0 > sight.EYE_HEIGHT_M:
            z = box.z1 if above else box.z0
            # A slab seen from above hides its legs; an object on the floor may carry others.
            hides = above and box.z0 > 0.0
            patches.append(
                _Patch(
                    order=float(near[hit].min() if hides else leave[hit].max()),
                    first=first,
                    top=view.row(z, leave if above else near),
                    bottom=view.row(z, near if above else leave),
                    seen=hit,
                    shade=sight.fade(near) * np.float32(1.08 if above else 0.55),
                    material=box.material,
                    u=None,
                )
            )
        return patches

    def _paint(self, frame: NDArray[np.uint8], patch: _Patch) -> None:
        tops, bottoms = patch.top[patch.seen], patch.bottom[patch.seen]
        low = max(0, math.floor(tops.min()))
        high = min(frame.shape[0], math.ceil(bottoms.max()))
        if low >= high:
            return
        rows = np.arange(low, high, dtype=np.float32)[:, None] + np.float32(0.5)
        area = frame[low:high, patch.first : patch.first + len(patch.top)]
        mask = ((rows >= patch.top) & (rows < patch.bottom) & patch.seen).view(np.uint8)
        if patch.u is None:
            colours = np.outer(patch.shade, paint.colour(patch.material))
            line = np.minimum(255.0, colours).astype(np.uint8)[None]
            cv2.copyTo(cv2.repeat(line, high - low, 1), mask, area)
            return
        tall = float((bottoms - tops).max())
        level = round(math.log2(paint.SIDE_PX / max(tall, 1.0)))
        level = min(_TEXTURE_LEVELS - 1, max(0, level))
        leafy = patch.material == "leaves"
        texture = (self._leaves if leafy else self._sides[patch.material])[level]
        v = (rows - patch.top) * (texture.shape[0] / np.maximum(patch.bottom - patch.top, 1e-3))
        v = np.asarray(v - 0.5, np.float32)
        u = cv2.repeat(
            np.asarray(patch.u * texture.shape[1] - 0.5, np.float32)[None], high - low, 1
        )
        dim = np.minimum(255.0, 255.0 * patch.shade).astype(np.uint8)
        dims = cv2.repeat(cv2.merge((dim, dim, dim)).reshape(1, -1, 3), high - low, 1)
        image = cv2.multiply(_look_up(texture, u, v), dims, scale=1.0 / 255.0)
        if leafy:
            mask &= (_look_up(self._leaf_masks[level], u, v) > 127).view(np.uint8)
        cv2.copyTo(image, mask, area)


def _look_up(
    texture: NDArray[np.uint8], u: cv2.typing.MatLike, v: cv2.typing.MatLike
) -> NDArray[np.uint8]:
    found = cv2.remap(texture, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found, np.uint8)


def _cylinder_patches(tube: Cylinder, view: View, wall_depth: NDArray[np.float32]) -> list[_Patch]:
    east, north = tube.x - view.eye_x, tube.y - view.eye_y
    ahead = east * view.ahead_x + north * view.ahead_y
    aside = east * view.ahead_y - north * view.ahead_x
    if ahead < sight.NEAR_M - tube.radius:
        return []
    if tube.leafy:
        depth = np.full(view.width, max(ahead, 0.15), np.float32)
        off = view.aside * depth - np.float32(aside)
        hit = np.abs(off) < tube.radius
        light = np.float32(1.0)
    else:
        square = view.x**2 + view.y**2
        half = view.x * east + view.y * north
        root = half**2 - square * (east**2 + north**2 - tube.radius**2)
        hit = root > 0.0
        depth = np.asarray((half - np.sqrt(np.maximum(root, 0.0))) / square, np.float32)
        off = view.aside * depth - np.float32(aside)
        light = 0.6 + 0.4 * np.sqrt(np.maximum(0.0, 1.0 - (off / tube.radius) ** 2))
    hit = hit & (depth > sight.NEAR_M) & (depth < wall_depth)
    columns = np.flatnonzero(hit)
    if not columns.size:
        return []
    cut = slice(int(columns[0]), int(columns[-1]) + 1)
    near = np.maximum(depth[cut], np.float32(sight.NEAR_M))
    return [
        _Patch(
            order=float(near[hit[cut]].min()),
            first=cut.start,
            top=view.row(tube.z1, near),
            bottom=view.row(tube.z0, near),
            seen=hit[cut],
            shade=sight.fade(near) * np.broadcast_to(light, depth.shape)[cut],
            material=tube.material,
            u=np.asarray(0.5 + 0.5 * off[cut] / tube.radius, np.float32),
        )
    ]


def _ahead(edges: NDArray[np.float32], view: View) -> NDArray[np.bool_]:
    """Return which boxes may be partly inside the cone of view, with a margin."""
    east = (edges[:, 0] + edges[:, 2]) / 2.0 - view.eye_x
    north = (edges[:, 1] + edges[:, 3]) / 2.0 - view.eye_y
    radius = np.hypot(edges[:, 2] - edges[:, 0], edges[:, 3] - edges[:, 1]) / 2.0
    ahead = east * view.ahead_x + north * view.ahead_y
    aside = np.abs(east * view.ahead_y - north * view.ahead_x)
    edge = float(np.abs(view.aside).max())
    inside = aside - radius * (1.0 + edge) < (ahead + radius) * edge
    return np.asarray((ahead > -radius) & inside)


def _halves(image: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    images = [image]
    for _ in range(_TEXTURE_LEVELS - 1):
        last = images[-1]
        half = (last.shape[1] // 2, last.shape[0] // 2)
        images.append(np.asarray(cv2.resize(last, half, interpolation=cv2.INTER_AREA), np.uint8))
    return images
