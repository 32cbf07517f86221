"""What the robot has besides wheels, from a finger on the page to the simulated robot."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from e2e.harness.robot import moves, stands_still
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

import pytest
import pytest_asyncio

CONTROLS = """
controls = [
  { name = "lamp", label = "Lamp", kind = "toggle", key = "KeyH", roles = ["observer"] },
  { name = "horn", label = "Horn", kind = "button", key = "KeyG" },
  { name = "look_around", label = "Look around", kind = "button", moves = true },
]
gauges = [{ name = "motor_c", label = "Motors", unit = "°C", decimals = 0, warn_above = 21.0 }]
[turns]
turn_s = 600.0
"""


@pytest_asyncio.fixture(loop_scope="session")
async def server(serve: Serve, tmp_path: Path) -> AsyncIterator[Server]:
    async with serve(tmp_path, CONTROLS) as server:
        yield server


async def robot_has(server: Server, name: str, value: float, within_s: float = 3.0) -> None:
    """Wait until the simulated robot itself says so."""

    async def so() -> bool:
        return bool((await server.status())["robot"][name] == value)

    await eventually(so, f"the robot's {name} is {value}", within_s=within_s)


async def press(viewer: Viewer, name: str) -> None:
    await viewer.button(name).hover()
    await viewer.page.mouse.down()


async def test_a_pressed_button_reaches_the_robot(server: Server, open_viewer: OpenViewer) -> None:
    """By finger and by key, as long as it is held; a toggle stays, and others see that it is on."""
    ada, eve = await open_viewer(server), await open_viewer(server)
    await ada.join()
    await ada.drives()
    await press(ada, "Horn")
    await robot_has(server, "horn", 1.0)
    await asyncio.sleep(1.0)
    await robot_has(server, "horn", 1.0)
    await ada.page.mouse.up()
    await robot_has(server, "horn", 0.0)
    await ada.page.keyboard.down("KeyG")
    await robot_has(server, "horn", 1.0)
    await ada.page.evaluate("window.dispatchEvent(new Event('blur'))")
    await robot_has(server, "horn", 0.0)
    await ada.page.keyboard.up("KeyG")
    await ada.page.keyboard.press("KeyH")
    await robot_has(server, "lamp", 1.0)
    await eve.page.get_by_role("button", name="Lamp", pressed=True).wait_for(timeout=3000)
    await eve.button("Lamp").click()
    await robot_has(server, "lamp", 0.0)
    await ada.page.get_by_role("button", name="Lamp", pressed=False).wait_for(timeout=3000)


@pytest.mark.full
async def test_an_observer_may_not(server: Server, open_viewer: OpenViewer) -> None:
    """They are not offered what is the operator's, nor does its key do anything for them."""
    ada, eve = await open_viewer(server), await open_viewer(server)
    await ada.join()
    await ada.drives()
    assert await eve.button("Lamp").is_visible()
    assert not await eve.button("Horn").is_visible()
    assert not await eve.button("Look around").is_visible()
    await eve.page.keyboard.down("KeyG")
    await asyncio.sleep(0.5)
    await robot_has(server, "horn", 0.0)
    counters = (await server.status())["counters"]
    assert "controls.refused.not_your_turn" not in counters


async def test_the_end_of_a_turn_releases_it(server: Server, open_viewer: OpenViewer) -> None:
    """What moves and what sounds ends with the turn though the finger stays on the button."""
    ada = await open_viewer(server)
    await ada.join()
    await ada.drives()
    await press(ada, "Look around")
    assert await moves(server)
    await ada.page.keyboard.down("KeyG")
    await robot_has(server, "horn", 1.0)
    await ada.page.get_by_role("button", name="End my turn").focus()
    await ada.page.keyboard.press("Enter")
    await robot_has(server, "horn", 0.0)
    assert await stands_still(server)
    assert not await ada.button("Look around").is_visible()


async def test_a_stop_releases_what_moves(server: Server, open_viewer: OpenViewer) -> None:
    """It stands at once, what moves waits for the release, and lamp and horn work meanwhile."""
    ada, eve = await open_viewer(server), await open_viewer(server)
    await ada.join()
    await ada.drives()
    await press(ada, "Look around")
    assert await moves(server)
    await eve.button("Stop").click()
    assert await stands_still(server)
    assert await ada.button("Look around").is_disabled()
    await ada.page.mouse.up()
    await ada.button("Lamp").click()
    await robot_has(server, "lamp", 1.0)
    await ada.release_stop()
    await press(ada, "Look around")
    assert await moves(server)
    await ada.page.mouse.up()
    assert await stands_still(server)


@pytest.mark.full
async def test_a_number_beyond_its_limit_is_over_the_picture(
    server: Server, open_viewer: OpenViewer
) -> None:
    """With its name and value; all of them are among the details."""
    ada = await open_viewer(server)
    await ada.page.locator(".hud").get_by_text("Motors").wait_for(timeout=5000)
    await ada.open("Details")
    gauges = ada.page.get_by_role("region", name="The robot", exact=True)
    assert "22 °C" in await gauges.inner_text()
