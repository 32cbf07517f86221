"""Chromium shaped like Safari: the oldest, and the first that can run our own player."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect
from tests.examples import at_length

from e2e.harness import probe
from e2e.harness.installed import needed
from e2e.harness.robot import holding_moves, moves, stands_still
from e2e.harness.safari import shaped_like
from e2e.harness.touch_screen import PHONE, TouchPoints
from e2e.harness.viewer import BROWSER, OWN, plays_by
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.measure.ear import Ear


@pytest.mark.timeout(90)
@pytest.mark.parametrize(("version", "player"), [*at_length((16.4, BROWSER)), (26.0, OWN)])
async def test_in_a_browser_like_safari_one_watches_hears_drives_and_takes_a_call(
    server: Server, open_viewer: OpenViewer, ear: Ear | None, version: float, player: str
) -> None:
    """It sounds after a tap, drives and stops; after a phone call it sounds again, and says so."""
    viewer = await open_viewer(server, first=shaped_like(version), **PHONE)
    offer = str(await viewer.probe("offer()"))
    assert "playout-delay" not in offer
    assert " red/" not in offer
    await viewer.listen()

    await viewer.takes_the_wheel()
    fingers = await TouchPoints.of(viewer)
    push = partial(fingers.push, 0, viewer.joystick, -60, 0)
    assert await holding_moves(server, push, lambda: fingers.lift(0))
    await push()
    assert await moves(server)
    await fingers.press(1, viewer.button("Stop"))
    await fingers.lift(1)
    assert await stands_still(server)
    await fingers.lift(0)
    await viewer.release_stop()
    await viewer.leave()
    await plays_by(viewer, player)
    await viewer.closes("Details")

    offered = viewer.button("Turn sound on")
    await viewer.page.evaluate("waxSafari.call()")
    await expect(offered).to_be_visible()
    await eventually(lambda: is_silent(needed(ear)), "the call has the sound")
    await viewer.page.evaluate("waxSafari.hangUp()")
    if player == BROWSER:
        await offered.tap()
    await expect(offered).to_be_hidden()
    assert await needed(ear).tap().hears(within_s=10)
    await viewer.sees_picture()


async def is_silent(ear: Ear) -> bool:
    tap = ear.tap()
    await asyncio.sleep(0.2)
    return probe.loudness(tap.take()) < 0.001
