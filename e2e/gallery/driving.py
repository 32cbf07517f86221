"""How one comes to drive, to drive slowly, and to be stopped."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from e2e.harness.robot import moves
from e2e.harness.touch_screen import TouchPoints

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.gallery.scene import Scene
    from e2e.harness.viewer import Viewer

    _Act = Callable[[], Awaitable[None]]

_BEGUN_S: Final = 1.0
"""A turn begins with nothing held; what is pressed before that moves nothing."""
_TRIES: Final = 5
_TOO_LATE_MS: Final = 3000
"""A host may have set this. As it is shipped, a busy machine's own delay makes late too late."""
_PUSH_PX: Final = 50
_LATE: Final = "e2e.gallery.late_camera:LateCamera"
_FROZEN: Final = "e2e.stop.camera:Camera"


async def driving(scene: Scene) -> None:
    """Turn the robot: by a key that is held, or by a finger."""
    await scene.serves()
    await scene.comes("Bob")
    viewer = await scene.drives()
    if not scene.is_touched:
        await _holds_on(scene, viewer)
        return
    points = await TouchPoints.of(viewer)

    async def pushes() -> None:
        await points.press(0, viewer.page.get_by_label("Joystick", exact=True))
        await points.slide(0, -_PUSH_PX, 0)

    await _until_it_moves(scene, pushes, lambda: points.lift(0))


async def _until_it_moves(scene: Scene, press: _Act, let_go: _Act) -> None:
    """Hold on, and do as the page asks where the robot stands: let go, and press again."""
    for _ in range(_TRIES):
        await asyncio.sleep(_BEGUN_S)
        await press()
        if await moves(scene.server, during_s=_BEGUN_S):
            return
        await let_go()
    raise AssertionError("the robot stands while it is driven")


async def _holds_on(scene: Scene, viewer: Viewer) -> None:
    keys = viewer.page.keyboard
    await _until_it_moves(scene, lambda: keys.down("ArrowLeft"), lambda: keys.up("ArrowLeft"))


async def slow(scene: Scene) -> None:
    """Drive by a picture that is late, but not too late, even where the machine is busy."""
    await scene.serves(
        video={"source": _LATE},
        audio={"source": "testcard"},
        drive={"stop_picture_age_ms": _TOO_LATE_MS},
    )
    viewer = await scene.drives()
    await viewer.speed("Fast").click()
    await _holds_on(scene, viewer)


async def paused(scene: Scene) -> None:
    """Freeze the camera while somebody drives."""
    camera = scene.camera()
    await scene.serves(
        environment=camera.environment, video={"source": _FROZEN}, audio={"source": "testcard"}
    )
    viewer = await scene.drives()
    await asyncio.sleep(_BEGUN_S)
    await viewer.page.keyboard.down("ArrowLeft")
    await camera.freeze()


async def stopped_by_you(scene: Scene) -> None:
    await scene.serves()
    viewer = await scene.drives()
    await viewer.button("Stop").click()


async def stopped_by_another(scene: Scene) -> None:
    await scene.serves()
    other = await scene.comes("Wanda")
    await scene.drives()
    await other.press_stop()


async def stopped_by_host(scene: Scene) -> None:
    await scene.serves()
    host = await scene.comes("Host", is_host=True)
    await scene.drives()
    await host.press_stop()


async def stopped_watched(scene: Scene) -> None:
    """Stop the robot before somebody who cannot release it."""
    await scene.serves()
    operator = await scene.somebody_drives()
    await scene.opens()
    await operator.press_stop()
