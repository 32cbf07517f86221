"""States of driving, of driving slowly, and of being stopped."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.harness import toml
from e2e.harness.robot import nothing_is_held, turn_by_key, until_it_moves
from e2e.harness.touch_screen import TouchPoints

if TYPE_CHECKING:
    from e2e.gallery.scene import Scene

_TOO_LATE_MS: Final = 3000
"""A host may set this; by default a busy machine's own delay would make every picture too late."""
_PUSH_PX: Final = 50
_LATE: Final = "e2e.stop.camera:LateCamera"


async def driving(scene: Scene) -> None:
    """Turn the robot by a held key, or by a finger."""
    await scene.comes("Bob")
    viewer = await scene.drives()
    if not scene.is_touched:
        await turn_by_key(scene.server, viewer)
        return
    points = await TouchPoints.of(viewer)
    await until_it_moves(
        scene.server,
        lambda: points.push(0, viewer.joystick, -_PUSH_PX, 0),
        lambda: points.lift(0),
    )


async def sideways(scene: Scene) -> None:
    """Drive a robot that also moves sideways."""
    await scene.serves(robot={"base": "mecanum"})
    await driving(scene)


async def slow(scene: Scene) -> None:
    """Drive by a picture that is late, but not too late, even if the machine is busy."""
    await scene.serves(
        video={"source": _LATE},
        audio=toml.MEDIA["audio"],
        drive={"stop_picture_age_ms": _TOO_LATE_MS},
    )
    viewer = await scene.drives()
    await viewer.speed("Fast").click()
    await turn_by_key(scene.server, viewer)


async def paused(scene: Scene) -> None:
    """Freeze the camera while somebody drives."""
    camera = await scene.serves_a_camera()
    viewer = await scene.drives()
    await nothing_is_held(scene.server)
    await viewer.page.keyboard.down("ArrowLeft")
    await camera.freeze()


async def stopped_by_you(scene: Scene) -> None:
    viewer = await scene.drives()
    await viewer.button("Stop").click()


async def _stopped_by(name: str, scene: Scene, *, is_host: bool = False) -> None:
    other = await scene.comes(name, is_host=is_host)
    await scene.drives()
    await other.press_stop()


stopped_by_another = partial(_stopped_by, "Wanda")
stopped_by_host = partial(_stopped_by, "Host", is_host=True)


async def stopped_watched(scene: Scene) -> None:
    """Stop the robot in the page of somebody who cannot release it."""
    operator = await scene.somebody_drives()
    await scene.opens()
    await operator.press_stop()
