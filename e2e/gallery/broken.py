"""Failures: of the robot, the camera, the connection, the server."""

from __future__ import annotations

import asyncio
import os
import signal
from typing import TYPE_CHECKING, Final

from e2e.harness import toml
from e2e.stop.camera import SOURCE

if TYPE_CHECKING:
    from e2e.gallery.scene import Scene

_LOST_S: Final = 6.0


async def robot_lost(scene: Scene) -> None:
    """Pull the cable between server and board while somebody drives."""
    board = await scene.board()
    await scene.serves(**toml.MEDIA, robot=board.robot)
    await scene.drives()
    await board.unplug()


async def camera_failed(scene: Scene) -> None:
    """Pull the camera's plug."""
    await scene.serves(video={"source": SOURCE}, audio=toml.MEDIA["audio"])
    await scene.opens()
    (scene.server.state_folder.parent / "pull").touch()


async def picture_frozen(scene: Scene) -> None:
    """Freeze a camera that does not report it."""
    camera = await scene.serves_a_camera()
    await scene.opens()
    await camera.freeze()


async def no_answer(scene: Scene) -> None:
    """Drop everything from the server, which may be reachable again in a moment."""
    await scene.drives()
    os.kill(scene.server.pid, signal.SIGSTOP)
    await asyncio.sleep(1.5)


async def reconnecting(scene: Scene) -> None:
    """Keep the server silent for longer than a page waits for it."""
    await scene.opens()
    os.kill(scene.server.pid, signal.SIGSTOP)
    await asyncio.sleep(_LOST_S)


async def server_gone(scene: Scene) -> None:
    """Kill the server, without a goodbye."""
    await scene.opens()
    await scene.server.kill()
    await asyncio.sleep(3)
