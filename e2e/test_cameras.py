"""Cameras other than the driving view: small, enlarged by a key or a tap, and gone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from e2e.harness import toml
from e2e.harness.robot import drives_on, turn_by_key, undisturbed
from e2e.harness.viewer import box_of
from e2e.harness.wait import eventually
from e2e.stop.camera import SOURCE
from wax.sentence import Sentence

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

SERVER_SETTINGS = f"""{toml.CARD}
[[camera]]
name = "Door"
source = "testcard"
[[camera]]
name = "Tail"
source = "{SOURCE}"
"""
TOP = "640x480 at 1000 kbit/s"


def sent(status: dict[str, Any]) -> dict[str, Any]:
    streams: dict[str, Any] = status["viewers"][-1]["streams"]
    return streams


async def shows(viewer: Viewer, at: int, width: int) -> None:
    async def is_so() -> bool:
        cards = await viewer.cards(6, at)
        moving = len({card.stamp_ms for card in cards if card.valid}) >= 5
        return moving and cards[-1].width == width

    await eventually(is_so, f"picture {at} is {width} wide", within_s=30)


@pytest.mark.timeout(120)
async def test_a_large_camera_dies_and_driving_goes_on(
    server: Server, open_viewer: OpenViewer
) -> None:
    """The driving view is always visible, is enlarged again with a message, and nothing stops."""
    viewer = await open_viewer(server)
    await shows(viewer, 1, 160)
    await viewer.page.keyboard.press("KeyC")
    await shows(viewer, 1, 640)
    await viewer.takes_the_wheel()
    await viewer.button("Make Driving view large").wait_for(state="hidden")  # a turn begins with it
    await shows(viewer, 2, 160)
    pulled = server.state_folder.parent / "pull"

    async def is_driven_on() -> bool:
        """Pull the camera's plug and put it back; return whether the robot drove on meanwhile."""
        await viewer.button("Make Tail large").click()
        await shows(viewer, 2, 640)
        await turn_by_key(server, viewer)
        driving_view = await box_of(viewer.page.locator("video").first)
        assert driving_view["width"] >= 120, "whoever drives does not see the driving view"
        pulled.touch()
        try:
            await viewer.page.get_by_text(
                f"Tail: {Sentence('camera.trouble')} The driving view is large again.", exact=True
            ).wait_for()
            is_driven = await drives_on(server)
            await viewer.page.keyboard.up("ArrowLeft")
            await shows(viewer, 0, 640)
            await server.until(
                lambda told: sent(told)["rendition"] == TOP,
                "the driving view is sent large",
                within_s=30,
            )
        finally:
            pulled.unlink()
        await shows(viewer, 2, 160)
        return is_driven

    stands = "the robot stands since a camera other than the driving view died"
    assert await undisturbed(server, is_driven_on), stands
