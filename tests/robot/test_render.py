"""What the simulated robot sees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest

from wax.driver.interface import Pose
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.render import Renderer

if TYPE_CHECKING:
    from numpy.typing import NDArray

WORLD = furnished_flat()


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(WORLD, 320, 240)


def share(image: NDArray[np.uint8], colour: str) -> float:
    """Return how much of the upper 2/5, which has no rug, has a saturated colour."""
    upper = image[: image.shape[0] * 2 // 5]
    blue, green, red = (upper[..., part].astype(int) for part in range(3))
    is_so = {
        "red": (red > 110) & (red > 2 * blue) & (red > 2 * green),
        "blue": (blue > 110) & (blue > 1.7 * red) & (blue > 1.4 * green),
        "green": (green > 80) & (green > 1.7 * blue) & (green > 1.7 * red),
        "yellow": (red > 120) & (green > 110) & (blue < 0.5 * green),
    }[colour]
    return float(is_so.mean())


@pytest.mark.parametrize(
    ("pose", "colour"),
    [
        (Pose(3.4, 2.6, 0.0), "red"),
        (Pose(6.9, 3.6, math.pi), "blue"),
        (Pose(8.5, 5.2, 0.0), "green"),
        (Pose(2.9, 3.9, 0.0), "yellow"),
    ],
    ids=["red pillar", "blue pillar", "green pillar", "yellow door"],
)
def test_landmarks_are_seen_only_where_they_are(
    renderer: Renderer, pose: Pose, colour: str
) -> None:
    """Facing a landmark shows much of its colour, facing away much less."""
    facing = share(renderer.draw(pose), colour)
    away = share(renderer.draw(Pose(pose.x_m, pose.y_m, pose.heading_rad + math.pi)), colour)
    assert facing > 0.02
    assert away < facing / 3


def test_a_nearer_landmark_is_larger(renderer: Renderer) -> None:
    """The nearer the robot, the more of the picture the red pillar fills."""
    shares = [share(renderer.draw(Pose(x, 2.6, 0.0)), "red") for x in (2.0, 3.0, 3.6)]
    assert shares[0] < shares[1] < shares[2]


def test_walls_hide_what_is_behind(renderer: Renderer) -> None:
    """The kitchen's blue pillar is not seen through the living room's wall."""
    assert share(renderer.draw(Pose(4.9, 3.3, 0.3)), "blue") < 0.002


def test_turning_left_moves_the_picture_right(renderer: Renderer) -> None:
    """A landmark moves to the right when the robot, or only its head, turns left."""

    def middle(pose: Pose, pan_rad: float) -> float:
        image = renderer.draw(pose, pan_rad).astype(int)
        reds = (image[..., 2] > 110) & (image[..., 2] > 2 * image[..., 0])
        reds &= image[..., 2] > 2 * image[..., 1]
        reds[96:] = False
        return float(np.median(np.nonzero(reds)[1]))

    here = Pose(2.6, 2.6, 0.0)
    assert middle(here, 0.0) == pytest.approx(160, abs=12)
    assert middle(here, 0.3) > 200
    assert middle(Pose(2.6, 2.6, 0.3), 0.0) == pytest.approx(middle(here, 0.3), abs=1)


def test_the_same_pose_is_the_same_picture() -> None:
    """Two cameras in one place see the same, bit by bit; another place looks different."""
    first, second = Renderer(WORLD, 320, 240), Renderer(WORLD, 320, 240)
    image = first.draw(WORLD.start).copy()
    assert np.array_equal(image, second.draw(WORLD.start))
    moved = Pose(WORLD.start.x_m + 0.1, WORLD.start.y_m, WORLD.start.heading_rad)
    assert np.mean(image != first.draw(moved)) > 0.05


def test_each_colour_is_looked_up_once(renderer: Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    """The atlas is read once, whatever stands before a wall, and not at all for the same place."""
    looked_up: list[int] = []
    remap = cv2.remap

    def counted(image: NDArray[np.uint8], *rest: Any, **options: Any) -> cv2.typing.MatLike:
        looked_up.append(image.ndim)
        return remap(image, *rest, **options)

    monkeypatch.setattr(cv2, "remap", counted)
    pose = Pose(4.0, 1.0, 2.0)
    first = renderer.draw(pose).copy()
    assert looked_up.count(3) == 1
    assert np.array_equal(renderer.draw(pose), first)
    assert looked_up.count(3) == 1
    renderer.draw(pose, 0.1)
    assert looked_up.count(3) == 2


@pytest.mark.parametrize(("width", "height"), [(32, 32), (160, 120), (800, 200), (202, 602)])
def test_any_size_can_be_drawn(width: int, height: int) -> None:
    """Pictures of any shape are drawn from anywhere, and no row is empty."""
    renderer = Renderer(WORLD, width, height)
    for pose in (WORLD.start, Pose(8.7, 6.3, 2.0), Pose(0.2, 5.2, -3.0)):
        image = renderer.draw(pose)
        assert image.shape == (height, width, 3)
        assert image.dtype == np.uint8
        assert (image.reshape(height, -1).max(axis=1) > 20).all()


def test_no_place_is_too_near_to_draw(renderer: Renderer) -> None:
    """There is a picture from every place that the robot can reach, in every direction."""
    rng = np.random.default_rng(2)
    drawn = 0
    while drawn < 40:
        x, y = float(rng.uniform(0, WORLD.width)), float(rng.uniform(0, WORLD.depth))
        if WORLD.nearest_surface(x, y)[0] < 0.17:
            continue
        image = renderer.draw(Pose(x, y, float(rng.uniform(-4, 4))), float(rng.uniform(-1, 1)))
        assert 30 < image.mean() < 235
        drawn += 1
