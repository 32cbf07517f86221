"""The flat that the simulated robot lives in: six rooms round a hall, 10 m by 9 m.

y 9 ┌──────────┬────────┬───────┐
    │ bedroom  │ study  │ bath  │
5.9 ├───  ─────┴──  ────┴─  ────┤
    │ hall                      │
4.5 ├──────  ─────┬───  ────────┤
    │ living room │   kitchen   │
    │                           │
  0 └─────────────┴─────────────┘
    0            5.5         x 10
"""

from __future__ import annotations

import math
from itertools import pairwise

from wax.driver.interface import Pose
from wax.robot.simulated.world import Box, Cylinder, Decal, Dweller, FlatRoom, Rug, World

WIDTH, DEPTH, HEIGHT = 10.0, 9.0, 2.5
WALL = 0.12
DOOR_HEIGHT = 2.05
ROBOT_HEIGHT = 0.6

ADA = Dweller("ada", 2.0, 3.85)
BEN = Dweller("ben", 8.8, 2.5)


def furnished_flat() -> World:
    """Build the flat; the robot starts in the living room, near the radio and Ada."""
    walls, lintels = _walls()
    return World(
        width=WIDTH,
        depth=DEPTH,
        height=HEIGHT,
        rooms=(
            FlatRoom("living room", 0.0, 0.0, 5.5, 4.5, wall="cream", floor="planks"),
            FlatRoom("kitchen", 5.5, 0.0, 10.0, 4.5, wall="mint", floor="checkers"),
            FlatRoom("hall", 0.0, 4.5, 10.0, 5.9, wall="white", floor="terracotta"),
            FlatRoom("bedroom", 0.0, 5.9, 4.2, 9.0, wall="sky", floor="carpet"),
            FlatRoom("study", 4.2, 5.9, 7.4, 9.0, wall="lilac", floor="dark planks"),
            FlatRoom("bath", 7.4, 5.9, 10.0, 9.0, wall="tiles", floor="small tiles"),
        ),
        walls=walls,
        boxes=(*lintels, *_doors(), *_furniture()),
        cylinders=_rounds(),
        decals=_decals(),
        rugs=(
            Rug(1.5, 1.2, 3.9, 3.0, "rug"),
            Rug(0.8, 4.95, 9.2, 5.45, "runner"),
            Rug(2.6, 6.3, 3.9, 7.7, "round rug"),
            Rug(8.3, 6.9, 9.1, 7.5, "bath mat"),
        ),
        radio=(4.95, 3.85),
        people=(ADA, BEN),
        start=Pose(x_m=1.1, y_m=0.9, heading_rad=math.radians(35.0)),
        robot_height=ROBOT_HEIGHT,
    )


def _walls() -> tuple[tuple[Box, ...], tuple[Box, ...]]:
    half = WALL / 2.0
    walls = [
        _wall(-WALL, -WALL, WIDTH + WALL, 0.0),
        _wall(-WALL, DEPTH, WIDTH + WALL, DEPTH + WALL),
        _wall(-WALL, 0.0, 0.0, DEPTH),
        _wall(WIDTH, 0.0, WIDTH + WALL, DEPTH),
        _wall(4.2 - half, 5.9 + half, 4.2 + half, DEPTH),
        _wall(7.4 - half, 5.9 + half, 7.4 + half, DEPTH),
    ]
    lintels = []
    rows = (
        (4.5, ((0.0, 2.6), (3.6, 7.0), (8.0, WIDTH))),
        (5.9, ((0.0, 1.3), (2.3, 5.3), (6.3, 8.2), (9.2, WIDTH))),
    )
    for y, pieces in rows:
        walls += [_wall(start, y - half, end, y + half) for start, end in pieces]
        lintels += [_lintel(a[1], y - half, b[0], y + half) for a, b in pairwise(pieces)]
    for start, end in ((0.0, 1.1), (2.7, 4.5 - half)):
        walls.append(_wall(5.5 - half, start, 5.5 + half, end))
    lintels.append(_lintel(5.5 - half, 1.1, 5.5 + half, 2.7))
    return tuple(walls), tuple(lintels)


def _wall(x0: float, y0: float, x1: float, y1: float) -> Box:
    return Box(x0, y0, x1, y1, 0.0, HEIGHT, "wall")


def _lintel(x0: float, y0: float, x1: float, y1: float) -> Box:
    return Box(x0, y0, x1, y1, DOOR_HEIGHT, HEIGHT, "lintel")


def _doors() -> tuple[Box, ...]:
    """Make the doors, open at a right angle to their walls, each in its room's colour."""
    return (
        Box(3.56, 3.5, 3.6, 4.44, 0.0, 2.0, "yellow door"),
        Box(7.96, 3.5, 8.0, 4.44, 0.0, 2.0, "green door"),
        Box(1.3, 5.96, 1.34, 6.9, 0.0, 2.0, "blue door"),
        Box(5.3, 5.96, 5.34, 6.9, 0.0, 2.0, "violet door"),
        Box(9.16, 5.96, 9.2, 6.9, 0.0, 2.0, "white door"),
    )


def _furniture() -> tuple[Box, ...]:
    living = (
        Box(0.0, 1.7, 0.3, 3.5, 0.0, 0.8, "sofa"),
        Box(0.3, 1.7, 0.85, 3.5, 0.0, 0.42, "sofa"),
        Box(0.0, 1.5, 0.85, 1.7, 0.0, 0.58, "sofa"),
        Box(0.0, 3.5, 0.85, 3.7, 0.0, 0.58, "sofa"),
        Box(2.2, 1.8, 3.2, 2.4, 0.3, 0.36, "oak"),
        *_legs(2.2, 1.8, 3.2, 2.4, 0.3),
        Box(4.9, 0.1, 5.3, 0.95, 0.0, 1.9, "books"),
        Box(1.9, 0.0, 3.5, 0.4, 0.0, 0.5, "walnut"),
        Box(4.75, 3.65, 5.15, 4.05, 0.0, 0.45, "stool"),
        Box(4.77, 3.75, 5.13, 3.95, 0.45, 0.75, "radio"),
    )
    kitchen = (
        Box(9.4, 0.7, 10.0, 3.3, 0.0, 0.9, "cupboard"),
        Box(9.35, 0.7, 10.0, 3.3, 0.9, 0.94, "granite"),
        Box(9.3, 0.0, 10.0, 0.7, 0.0, 1.8, "fridge"),
        Box(9.4, 3.3, 10.0, 3.9, 0.0, 0.92, "stove"),
        Box(6.7, 1.5, 8.0, 2.3, 0.7, 0.75, "pine"),
        *_legs(6.7, 1.5, 8.0, 2.3, 0.7),
        Box(6.85, 0.95, 7.25, 1.35, 0.4, 0.44, "red"),
        *_legs(6.85, 0.95, 7.25, 1.35, 0.4),
        Box(7.45, 2.5, 7.85, 2.9, 0.4, 0.44, "blue"),
        *_legs(7.45, 2.5, 7.85, 2.9, 0.4),
    )
    rest = (
        Box(0.0, 7.1, 2.1, 8.7, 0.0, 0.45, "bed"),
        Box(0.0, 7.0, 0.08, 8.8, 0.0, 1.0, "walnut"),
        Box(0.1, 7.3, 0.55, 7.8, 0.45, 0.58, "pillow"),
        Box(0.1, 8.0, 0.55, 8.5, 0.45, 0.58, "pillow"),
        Box(2.8, 8.4, 4.1, 9.0, 0.0, 2.0, "wardrobe"),
        Box(4.7, 8.3, 6.4, 8.95, 0.7, 0.75, "oak"),
        *_legs(4.7, 8.3, 6.4, 8.95, 0.7),
        Box(5.2, 8.65, 5.9, 8.72, 0.78, 1.2, "screen"),
        Box(7.0, 6.3, 7.34, 8.6, 0.0, 2.1, "books"),
        Box(9.25, 7.4, 10.0, 9.0, 0.0, 0.55, "bathtub"),
        Box(7.46, 8.4, 7.96, 8.9, 0.0, 0.8, "washstand"),
        Box(3.9, 5.55, 4.9, 5.84, 0.0, 0.85, "sideboard"),
    )
    return (*living, *kitchen, *rest)


def _legs(x0: float, y0: float, x1: float, y1: float, height: float) -> tuple[Box, ...]:
    thick = 0.05
    return tuple(
        Box(x, y, x + thick, y + thick, 0.0, height, "leg")
        for x in (x0, x1 - thick)
        for y in (y0, y1 - thick)
    )


def _rounds() -> tuple[Cylinder, ...]:
    return (
        Cylinder(4.2, 2.6, 0.16, 0.0, HEIGHT, "red pillar"),
        Cylinder(6.1, 3.6, 0.16, 0.0, HEIGHT, "blue pillar"),
        Cylinder(9.4, 5.2, 0.16, 0.0, HEIGHT, "green pillar"),
        *_plant(0.5, 4.05, 0.95),
        *_plant(5.9, 0.5, 0.8),
        *_plant(0.4, 5.2, 1.2),
        *_plant(6.7, 8.6, 0.9),
        *_plant(3.9, 6.3, 0.8),
        *_person(ADA, "violet jumper"),
        *_person(BEN, "white jumper"),
    )


def _plant(x: float, y: float, height: float) -> tuple[Cylinder, ...]:
    return (
        Cylinder(x, y, 0.15, 0.0, 0.32, "pot"),
        Cylinder(x, y, 0.34, 0.26, 0.32 + height, "leaves", leafy=True),
    )


def _person(dweller: Dweller, clothes: str) -> tuple[Cylinder, ...]:
    """Make a person at this place, who always faces the robot."""
    return (
        Cylinder(dweller.x, dweller.y, 0.2, 0.0, 1.42, clothes),
        Cylinder(dweller.x, dweller.y, 0.11, 1.42, 1.7, "face"),
    )


def _decals() -> tuple[Decal, ...]:
    south_of_hall, north_of_hall = 4.5 + WALL / 2.0, 5.9 - WALL / 2.0
    return (
        Decal(0.0, 2.6, 1.55, 1.3, 0.9, "sailing boat"),
        Decal(2.7, 0.0, 1.15, 1.3, 0.75, "television"),
        Decal(1.0, 0.0, 1.4, 0.8, 1.1, "window"),
        Decal(4.2, 0.0, 1.4, 0.8, 1.1, "window"),
        Decal(1.4, 4.44, 1.5, 0.9, 0.9, "sun poster"),
        Decal(7.2, 0.0, 1.5, 1.6, 1.0, "window"),
        Decal(10.0, 2.0, 1.6, 1.6, 0.6, "shelf"),
        Decal(9.0, 4.44, 1.7, 0.5, 0.5, "wall clock"),
        Decal(6.3, 4.44, 1.5, 0.7, 0.9, "fruit"),
        Decal(2.2, 9.0, 1.5, 1.4, 1.0, "window"),
        Decal(0.0, 7.9, 1.6, 1.0, 0.7, "moon"),
        Decal(5.5, 9.0, 1.75, 1.2, 0.7, "map"),
        Decal(4.26, 7.6, 1.4, 0.9, 1.1, "rocket"),
        Decal(8.7, 9.0, 1.6, 0.7, 0.7, "window"),
        Decal(7.46, 8.65, 1.4, 0.5, 0.7, "mirror"),
        Decal(0.0, 5.2, 1.4, 0.8, 1.1, "window"),
        Decal(10.0, 5.2, 1.4, 0.9, 1.3, "cat"),
        Decal(2.2, south_of_hall, 1.15, 0.6, 0.2, "LIVING ROOM"),
        Decal(6.6, south_of_hall, 1.15, 0.6, 0.2, "KITCHEN"),
        Decal(2.7, north_of_hall, 1.15, 0.6, 0.2, "BEDROOM"),
        Decal(6.7, north_of_hall, 1.15, 0.6, 0.2, "STUDY"),
        Decal(7.8, north_of_hall, 1.15, 0.6, 0.2, "BATH"),
        Decal(4.6, south_of_hall, 1.5, 0.8, 0.8, "sun poster"),
        Decal(2.2, 4.44, 1.15, 0.5, 0.18, "HALL"),
        Decal(6.6, 4.44, 1.15, 0.5, 0.18, "HALL"),
        Decal(5.5 - WALL / 2.0, 3.0, 1.15, 0.5, 0.18, "KITCHEN"),
        Decal(5.5 + WALL / 2.0, 3.0, 1.15, 0.5, 0.18, "LIVING ROOM"),
    )
