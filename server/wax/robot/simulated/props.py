"""Places furniture, doors, pillars and plants over the walls, from far to near (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from wax.robot.simulated import atlas, paint
from wax.robot.simulated import view as sight
from wax.robot.simulated.lookup import Strip

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.robot.simulated.atlas import Atlas
    from wax.robot.simulated.lookup import Lookup
    from wax.robot.simulated.view import View
    from wax.robot.simulated.world import Cylinder, World

_MIDDLE_PX = 4.0
"""Within the picture of a top, which has one colour."""


@dataclass(frozen=True, slots=True)
class _Patch:
    """Covers columns from `first`: rows `top` to `bottom` of each column, where `seen`.

    `u` is the share of the texture's width, None for a plain face. The patch with the largest
    `order` is placed first.
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

    def __init__(self, world: World, baked: Atlas) -> None:
        self._atlas = baked
        self._boxes = world.boxes
        self._cylinders = world.cylinders
        edges = [(b.x0, b.y0, b.x1, b.y1) for b in world.boxes]
        self._edges = np.array(edges, np.float32).reshape(-1, 4)

    def put(self, lookup: Lookup, view: View, wall_depth: NDArray[np.float32]) -> None:
        """Place what `view` shows of it; nearer walls hide it."""
        patches = self._box_patches(view, wall_depth)
        for tube in self._cylinders:
            patches += _cylinder_patches(tube, view, wall_depth)
        for patch in sorted(patches, key=lambda patch: -patch.order):
            lookup.put(self._strip(patch), has_holes=patch.material == "leaves")

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
                    shade=sight.fade(near) * np.float32(1.0 if above else 0.55 / paint.TOP_LIGHT),
                    material=box.material,
                    u=None,
                )
            )
        return patches

    def _strip(self, patch: _Patch) -> Strip:
        tall = patch.bottom - patch.top
        if patch.u is None:
            corner = self._atlas.tops[patch.material][0] + _MIDDLE_PX
            u, v = np.full(len(tall), corner[0], np.float32), float(corner[1])
            slope = np.zeros(len(tall), np.float32)
        else:
            whole_px = paint.LEAVES_PX if patch.material == "leaves" else paint.SIDE_PX
            tallest = np.maximum(tall[patch.seen].max(), np.float32(1.0))
            level = int(atlas.level(paint.SIDE_PX / tallest))
            corner = self._atlas.sides[patch.material][level]
            size = np.float32(whole_px >> level)
            u, v = corner[0] + patch.u * size, float(corner[1])
            slope = size / np.maximum(tall, np.float32(1e-3))
        return Strip(
            first=patch.first,
            top=patch.top,
            bottom=patch.bottom,
            seen=patch.seen,
            u=np.asarray(u, np.float32),
            v=v,
            slope=slope,
            shade=patch.shade,
        )


def _cylinder_patches(tube: Cylinder, view: View, wall_depth: NDArray[np.float32]) -> list[_Patch]:
    east, north = tube.x - view.eye_x, tube.y - view.eye_y
    ahead = east * view.ahead_x + north * view.ahead_y
    aside = east * view.ahead_y - north * view.ahead_x
    edge = float(view.aside[-1])
    if ahead < sight.NEAR_M - tube.radius or _is_beside(ahead, abs(aside), tube.radius, edge):
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
    edge = float(view.aside[-1])
    return np.asarray((ahead > -radius) & ~_is_beside(ahead, aside, radius, edge))


def _is_beside(ahead: Any, aside: Any, radius: Any, edge: float) -> Any:
    """Return whether what is so far off the line of sight cannot be in the picture's `edge`."""
    return aside - radius * (1.0 + edge) >= (ahead + radius) * edge
