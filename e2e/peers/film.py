"""The test card's cells above a film: a drive through the simulated flat, there and back.

It is painted when it is opened, since painting takes more of a processor than a camera does.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

from wax.capture.source import Picture
from wax.capture.testcard import TestCardVideo
from wax.driver.interface import Pose
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.render import Renderer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_FPS: Final = 30
_COUNT: Final = 90
_FROM: Final = (3.0, 2.6, -0.9)
_PER_S: Final = (0.3, 0.1, 0.5)
"""By what the camera moves and turns, in metres and radians as in `Pose`."""


class FilmCard(TestCardVideo):
    """Shows the same picture of the film at the same moment, in whichever process."""

    def open(self) -> None:
        super().open()
        _film(self.width, self.height)

    def paint(self, wall_ms: int) -> NDArray[np.uint8]:
        number = wall_ms * _FPS // 1000 % (2 * _COUNT)
        return _film(self.width, self.height)[min(number, 2 * _COUNT - 1 - number)].copy()


@cache
def _film(width: int, height: int) -> list[NDArray[np.uint8]]:
    renderer = Renderer(furnished_flat(), width, height)

    def picture(number: int) -> NDArray[np.uint8]:
        moved = zip(_FROM, _PER_S, strict=True)
        pose = Pose(*(start + number / _FPS * per_s for start, per_s in moved))
        return Picture.from_bgr(renderer.draw(pose), 0.0).i420

    return [picture(number) for number in range(_COUNT)]
