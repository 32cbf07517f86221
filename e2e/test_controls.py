"""The robot's controls other than wheels, from a finger on the page to the simulated robot."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from e2e.harness.robot import stands_still, undisturbed, until_it_moves
from e2e.harness.wait import happens

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

SERVER_SETTINGS = """
controls = [
  { name = "lamp", label = "Lamp", kind = "toggle", key = "KeyH", roles = ["observer"] },
  { name = "horn", label = "Horn", kind = "button", key = "KeyG" },
  { name = "look_around", label = "Look around", kind = "button", moves = true },
]
gauges = [{ name = "motor_c", label = "Motors", unit = "°C", decimals = 0, warn_above = 21.0 }]
[turns]
turn_s = 600.0
"""


async def robot_has(server: Server, name: str, value: float) -> None:
    what = f"the robot's {name} is {value}"
    await server.until(lambda told: told["robot"][name] == value, what)


async def sounds(
    server: Server, press: Callable[[], Awaitable[None]], let_go: Callable[[], Awaitable[None]]
) -> None:
    """Hold on until the horn sounds, and for longer than one of its messages counts."""

    async def is_on() -> bool:
        return bool((await server.status())["robot"]["horn"] == 1.0)

    async def attempt() -> bool:
        await press()
        if await happens(is_on, within_s=2.0):
            await asyncio.sleep(0.5)
            if await is_on():
                return True
        await let_go()
        return False

    assert await undisturbed(server, attempt), "the horn is silent while it is held"


async def press(viewer: Viewer, name: str) -> None:
    await viewer.button(name).hover()
    await viewer.page.mouse.down()


async def looks_around(server: Server, viewer: Viewer) -> None:
    """Hold the button that turns the robot until it turns."""
    await expect(viewer.button("Look around")).to_be_enabled()
    await until_it_moves(server, lambda: press(viewer, "Look around"), viewer.page.mouse.up)


@pytest.mark.timeout(120)
async def test_what_is_pressed_reaches_the_robot_until_it_may_not(
    server: Server, driver: Viewer, open_viewer: OpenViewer
) -> None:
    """They work by finger and key while held; a Stop and the end of the turn release what moves."""
    ada, eve = driver, await open_viewer(server)
    assert not await eve.button("Horn").is_visible(), "an observer is offered the operator's"
    keys = ada.page.keyboard
    by_key = partial(keys.down, "KeyG"), partial(keys.up, "KeyG")
    await sounds(server, lambda: press(ada, "Horn"), ada.page.mouse.up)
    await ada.page.mouse.up()
    await robot_has(server, "horn", 0.0)
    await sounds(server, *by_key)
    await keys.up("KeyG")
    await robot_has(server, "horn", 0.0)
    await keys.press("KeyH")
    await robot_has(server, "lamp", 1.0)
    await eve.page.get_by_role("button", name="Lamp", pressed=True).wait_for()
    await eve.button("Lamp").click()
    await robot_has(server, "lamp", 0.0)
    await ada.page.get_by_role("button", name="Lamp", pressed=False).wait_for()

    # It stops at once, what moves waits for the release, and the lamp works meanwhile.
    await looks_around(server, ada)
    await eve.button("Stop").click()
    assert await stands_still(server)
    await expect(ada.button("Look around")).to_be_disabled()
    await ada.page.mouse.up()
    await ada.button("Lamp").click()
    await robot_has(server, "lamp", 1.0)
    await ada.release_stop()

    # The finger stays on the button while the turn ends.
    await looks_around(server, ada)
    await sounds(server, *by_key)
    await ada.page.get_by_role("button", name="End my turn").focus()
    await keys.press("Enter")
    await robot_has(server, "horn", 0.0)
    assert await stands_still(server)
    await expect(ada.button("Look around")).to_be_hidden()

    # A gauge beyond its limit is shown over the picture.
    await ada.page.locator(".hud").get_by_text("Motors").wait_for()
