"""What a viewer switches off or opens, and what the host does to everybody."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from e2e.gallery.scene import Scene


async def picture_off(scene: Scene) -> None:
    viewer = await scene.drives()
    await viewer.open("Settings")
    await viewer.switch("Picture").click()
    await viewer.closes("Settings")


async def blanked(scene: Scene) -> None:
    host = await scene.comes("Host", is_host=True)
    await scene.opens()
    host.send(type="blank", blanked=True)


async def console(scene: Scene) -> None:
    """Open the host's console while somebody drives and somebody waits."""
    await scene.somebody_drives()
    await scene.somebody_waits()
    viewer = await scene.opens(is_host=True)
    await viewer.open("Host")


async def people(scene: Scene) -> None:
    await scene.somebody_drives()
    await scene.somebody_waits()
    viewer = await scene.opens()
    await viewer.open("People")


async def _opened(panel: str, scene: Scene) -> None:
    viewer = await scene.drives()
    await viewer.open(panel)


settings, details = partial(_opened, "Settings"), partial(_opened, "Details")


async def rules(scene: Scene) -> None:
    viewer = await scene.opens()
    await viewer.open("Safety")
