"""Every state in every window and theme can be seen, operated and read out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import pytest
import pytest_asyncio

from e2e.gallery import axe, layout
from e2e.gallery.shots import shoot, write_page
from e2e.gallery.states import STATES, named
from e2e.gallery.views import ACROSS, COMPUTER, DESKTOP, DEVICES, UPRIGHT, View

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser, ViewportSize

    from e2e.gallery.scene import Scene
    from e2e.gallery.states import State
    from e2e.gallery.views import Device, Theme

pytestmark = pytest.mark.timeout(180)

ZOOMED: Final = ("driving", "sideways", "free", "settings", "console")
ZOOM: Final = 2
"""WCAG 1.4.4: text at 200 %, which halves a window's CSS pixels."""
HALVED: Final[ViewportSize] = {"width": DESKTOP.width // ZOOM, "height": DESKTOP.height // ZOOM}


@pytest_asyncio.fixture(scope="module", loop_scope="session", autouse=True)
async def _gallery() -> AsyncIterator[None]:
    """Show the pictures that the tests have taken."""
    yield
    write_page()


def _every() -> list[Any]:
    return [
        pytest.param(state, device, id=f"{state.key}-{device.key}")
        for state in STATES
        for device in DEVICES
    ]


async def _wrong(scene: Scene, state: State, view: View) -> list[str]:
    await view.show(scene.viewer.page)
    found = await layout.faults(scene.viewer.page, has_stop=state.has_stop)
    found += await axe.findings(scene.viewer.page)
    return [f"{view.key}: {one}" for one in found]


def _assert_none(findings: list[str]) -> None:
    assert not findings, "\n" + "\n".join(findings)


async def test_driving_has_no_finding(chromium: Browser) -> None:
    """No rule of WCAG 2.2 AA is broken, Stop is uncovered, and no target is small."""
    state, views = named("driving"), (View(ACROSS, "dark"), View(UPRIGHT, "light"))
    async with state.reached(chromium, views[0].device) as scene:
        _assert_none([one for view in views for one in await _wrong(scene, state, view)])


@pytest.mark.full
@pytest.mark.parametrize(("state", "device"), _every())
async def test_every_state_has_no_finding(chromium: Browser, state: State, device: Device) -> None:
    """The same holds in every state, window and theme; each is photographed for the gallery."""
    wrong = []
    async with state.reached(chromium, device) as scene:
        for view in device.views:
            wrong += await _wrong(scene, state, view)
            await shoot(scene, state, view)
        assert scene.viewer.errors == []
    _assert_none(wrong)


@pytest.mark.full
@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("key", ZOOMED)
async def test_at_200_percent_everything_is_there(
    chromium: Browser, key: str, theme: Theme
) -> None:
    """With text twice as large nothing leaves the window sideways, and Stop is in it."""
    state = named(key)
    async with state.reached(chromium, COMPUTER) as scene:
        page = scene.viewer.page
        await View(DESKTOP, theme).show(page)
        await page.set_viewport_size(HALVED)
        found = await layout.faults(page, has_stop=state.has_stop)
        _assert_none(found + await axe.findings(page))


@pytest.mark.full
async def test_at_200_percent_one_joins_drives_and_stops(chromium: Browser) -> None:
    """With text twice as large a visitor can do everything by the buttons themselves."""
    async with named("free").reached(chromium, COMPUTER) as scene:
        viewer = scene.viewer
        await viewer.page.set_viewport_size(HALVED)
        await viewer.takes_the_wheel()
        await viewer.button("Stop").click()
        await named("stopped-by-you").mark(viewer.page).wait_for(state="visible")
        await viewer.release_stop()


@pytest.mark.full
@pytest.mark.parametrize("key", ["driving", "free", "settings"])
async def test_colours_and_motion_are_the_readers(chromium: Browser, key: str) -> None:
    """Forced colours keep the edges of buttons and chosen options; less motion stops motion."""
    async with named(key).reached(chromium, COMPUTER) as scene:
        page = scene.viewer.page
        _assert_none(await layout.vanished(page) + await layout.moving(page))
