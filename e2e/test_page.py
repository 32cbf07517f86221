"""The page as a thing to be used: by name, by thumb, under its own security policy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
import pytest_asyncio
from playwright.async_api import expect

from e2e.harness import toml
from e2e.harness.robot import turn_by_key
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
THUMB_PX = 48
DRIVE_BUTTONS = ("Forward", "Back", "Left", "Right")


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    settings = toml.card_with(turns=toml.BRIEF_GRACE)
    async with serve(tmp_path_factory.mktemp("page"), settings) as running:
        yield running


@pytest.mark.timeout(60)
async def test_every_control_has_its_role_and_name(server: Server, open_viewer: OpenViewer) -> None:
    """Whoever cannot see the page finds every control by role and name, each exactly once."""
    viewer = await open_viewer(server)
    await viewer.button("Turn sound on").wait_for(state="visible")
    await viewer.button("Join the queue").wait_for(state="visible")
    assert await viewer.switch("Sound").count() == 1
    assert await viewer.name.count() == 1
    assert await viewer.queue.count() == 1
    await viewer.open("Settings")
    assert await viewer.switch("Picture").count() == 1
    assert await viewer.size.count() == 1
    assert await viewer.page.get_by_role("status").count() >= 1
    await viewer.join()
    await viewer.drives()
    await viewer.button("End my turn").wait_for(state="visible")
    for name in (*DRIVE_BUTTONS, "Stop"):
        assert await viewer.button(name).count() == 1, name
    for name in ("Slow", "Fast"):
        assert await viewer.speed(name).count() == 1, name
    assert await viewer.timer.count() >= 1


@pytest.mark.timeout(60)
async def test_the_page_keeps_its_own_security_policy(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Nothing of the page is refused by the policy that the server sends with it."""
    viewer = await open_viewer(server)
    await viewer.listen()
    said = ("Content Security Policy", "Permissions-Policy", "Permissions policy", "Opener-Policy")
    assert not [line for line in viewer.console if any(name in line for name in said)]
    assert not [line for line in viewer.console if line.startswith("error:")], viewer.console


@pytest.mark.timeout(60)
async def test_nothing_is_fetched_from_elsewhere(server: Server, open_viewer: OpenViewer) -> None:
    """The page asks no other host for anything."""
    viewer = await open_viewer(server)
    await viewer.page.reload()
    names = await viewer.page.evaluate(
        "() => performance.getEntriesByType('resource').map((entry) => entry.name)"
    )
    assert names, "the page has loaded nothing?"
    assert all(name.startswith((server.url, "blob:", "data:")) for name in names), names


@pytest.mark.timeout(60)
@pytest.mark.parametrize("control", ["Joystick", "Buttons"])
async def test_a_phone_has_everything_under_the_thumbs(
    server: Server, open_viewer: OpenViewer, control: str
) -> None:
    """On a phone nothing scrolls sideways, and what one drives by is large and in view."""
    viewer = await open_viewer(server, **PHONE)
    await viewer.drive_by(control)
    await viewer.join()
    await viewer.drives()
    wide = await viewer.page.evaluate("() => document.documentElement.scrollWidth")
    assert wide <= PHONE["viewport"]["width"]  # type: ignore[index]  # a mapping of its own
    assert await viewer.page.evaluate("() => window.scrollY") == 0
    stick = viewer.page.get_by_label("Joystick", exact=True)
    drives = [stick] if control == "Joystick" else [viewer.button(name) for name in DRIVE_BUTTONS]
    for name in (*drives, viewer.button("Stop")):
        box = await name.bounding_box()
        assert box is not None, f"{name} is not shown"
        assert min(box["width"], box["height"]) >= THUMB_PX, (name, box)
        assert box["x"] >= 0, (name, box)
        assert box["x"] + box["width"] <= 390, (name, box)
        assert box["y"] >= 0, (name, box)
        assert box["y"] + box["height"] <= 844, (name, box)


@pytest.mark.timeout(60)
async def test_a_half_typed_name_stays(server: Server, open_viewer: OpenViewer) -> None:
    """News of the room do not wipe what is being typed."""
    viewer = await open_viewer(server)
    await viewer.name.click()
    await viewer.page.keyboard.type("Ad")
    await (await open_viewer(server)).join()
    await viewer.queue.get_by_text("driving").first.wait_for()
    await viewer.page.keyboard.type("a")
    await viewer.name.press("Enter")

    async def named() -> bool:
        return "Ada" in [line["name"] for line in (await server.status())["viewers"]]

    await eventually(named, "the whole name is known", within_s=3)


@pytest.mark.timeout(60)
async def test_one_can_drive_by_keyboard_alone(server: Server, open_viewer: OpenViewer) -> None:
    """With Tab, Enter and the arrow keys one joins and drives, without a pointer."""
    viewer = await open_viewer(server)
    join = viewer.button("Join the queue")
    await expect(join).to_be_enabled()  # it takes no focus before the page is connected
    await join.focus()
    await viewer.page.keyboard.press("Enter")
    await viewer.drives()
    await turn_by_key(server, viewer)
    await viewer.page.keyboard.up("ArrowLeft")
