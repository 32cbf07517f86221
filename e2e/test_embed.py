"""A frame on another site, with third-party cookies blocked: it shows the robot, and no more."""

from __future__ import annotations

import re
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import pytest
from aiohttp import web
from playwright.async_api import async_playwright, expect
from tests.free_port import free_port

from e2e.harness import toml
from e2e.harness.bidi import firefox
from e2e.harness.chromium import launch_chromium
from e2e.harness.robot import moves
from e2e.harness.scripts import reads
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from playwright.async_api import Browser

    from e2e.conftest import Serve
    from e2e.harness.server import Server

NO_THIRD_PARTY: Final = "--test-third-party-cookie-phaseout"
NO_COOKIE: Final = {"network.cookie.cookieBehavior": 1}
"""Blocks third-party cookies in Firefox."""
WITHOUT_ORIGIN: Final = ("", "allow-scripts", "allow-scripts allow-popups")
"""Values of `sandbox`; WordPress uses the second."""
WITH_ORIGIN: Final = (
    "allow-scripts allow-same-origin",
    "allow-scripts allow-forms allow-same-origin allow-popups",
)
ISOLATED: Final = {"Cross-Origin-Embedder-Policy": "require-corp"}
"""The headers of a site that has isolated itself from others, so that it shows fewer frames."""
HERE: Final = "http://localhost:{}"
EXAMPLE: Final = Path(__file__).parents[1] / "config/examples/embed.html"
TRIES: Final = "(document.cookie = 'tried=1; SameSite=None; Secure', document.cookie)"

pytestmark = pytest.mark.timeout(120)


@asynccontextmanager
async def sites(
    *ports: int, headers: Mapping[str, str] = MappingProxyType({})
) -> AsyncIterator[dict[str, str]]:
    """Serve these pages, by path, on sites whose names differ from the robot's, 127.0.0.1."""
    pages: dict[str, str] = {}

    async def page(request: web.Request) -> web.Response:
        text = f"<!doctype html><title>Museum</title>{pages.get(request.path, '')}"
        return web.Response(text=text, content_type="text/html", headers=headers)

    application = web.Application()
    application.router.add_get("/{path:.*}", page)
    runner = web.AppRunner(application)
    await runner.setup()
    try:
        for port in ports:
            await web.TCPSite(runner, "localhost", port).start()
        yield pages
    finally:
        await runner.cleanup()


def allowing(port: int) -> str:
    """Return the configuration of a robot that this port's site may show."""
    return toml.card_with(page=f'embed_on = ["{HERE.format(port)}"]')


async def line(server: Server) -> str:
    """Return the line of HTML for other sites, as a site that was given a link requests it."""
    url = server.url.replace(":", "%3A").replace("/", "%2F")
    code, told = await server.get(f"/oembed?url={url}%2F&format=json")
    assert code == 200
    return str(told["html"])


async def test_the_example_page_shows_the_robot(
    chromium: Browser, serve: Serve, tmp_path: Path
) -> None:
    """The page in `config/examples` plays, with the configuration that it names."""
    port = free_port()
    code = EXAMPLE.read_text(encoding="utf-8").replace("https://museum.example", HERE.format(port))
    [said] = re.findall(r"embed_on = .*", code)
    async with sites(port) as pages, serve(tmp_path, toml.card_with(page=said)) as server:
        pages["/"] = code.replace("https://robot.example.org", server.url)
        context = await chromium.new_context()
        viewer = await Viewer.prepare(context, server.url)
        await viewer.page.goto(HERE.format(port))
        frame = viewer.page.frames[1]
        await eventually(lambda: frame.evaluate("waxProbe.playing()"), "the frame's picture plays")
        await expect(viewer.page.get_by_role("link")).to_have_attribute("href", f"{server.url}/")
        await context.close()


@pytest.mark.full
async def test_a_frame_shows_the_robot_and_moves_nothing(serve: Serve, tmp_path: Path) -> None:
    """It plays, says who drives, and sounds after a press; no key has any effect.

    The named site may show it, by the line that oEmbed gives; no site may show the page itself.
    """
    museum, other = free_port(), free_port()
    async with (
        sites(museum, other) as pages,
        serve(tmp_path, allowing(museum)) as server,
        async_playwright() as playwright,
        await launch_chromium(playwright, NO_THIRD_PARTY) as browser,
    ):
        pages["/"] = await line(server)
        pages["/page"] = f'<iframe src="{server.url}/"></iframe>'
        context = await browser.new_context(viewport={"width": 1280, "height": 720})
        viewer = await Viewer.prepare(context, server.url)
        await viewer.page.goto(f"http://localhost:{museum}/")
        frame = viewer.page.frame_locator("iframe")
        await expect(frame.get_by_text("the robot is free")).to_be_visible(timeout=20_000)
        inside = viewer.page.frames[1]
        await eventually(lambda: inside.evaluate("waxProbe.playing()"), "the frame's picture plays")
        assert await inside.evaluate(TRIES) == "", "this browser lets third parties have cookies"
        assert await context.cookies() == []

        async with Operator(server.url, name="Grace") as operator:
            await operator.join()
            await frame.get_by_text("Grace is driving").click()
            # What drives, speaks and stops on the page.
            for key in ("ArrowLeft", "w", "Space", "Escape", "t"):
                await frame.locator("body").press(key, delay=100)
            assert not await moves(server, within_s=0.5)
            assert operator.newest("room")["stop"] is None
        await frame.get_by_role("button", name="Turn sound on").click()
        await expect(frame.get_by_role("button", name="Mute")).to_be_visible()
        assert await frame.get_by_role("button").count() == 1

        for url in (f"http://localhost:{museum}/page", f"http://localhost:{other}/"):
            viewer.console.clear()
            await viewer.page.goto(url)
            await eventually(lambda: refused(viewer), f"the frame of {url} is refused")
            assert await viewer.page.frame_locator("iframe").get_by_role("main").count() == 0


async def refused(viewer: Viewer) -> bool:
    """Return whether the browser has said that the frame is not allowed."""
    return any("frame-ancestors" in one for one in viewer.console)


@pytest.mark.full
async def test_in_a_sandbox_it_plays_or_says_where_it_does(
    chromium: Browser, serve: Serve, tmp_path: Path
) -> None:
    """With an origin it plays, and its link opens the page or becomes the address to copy.

    Without one it gets neither script nor style: a sentence and the address are in its HTML.
    """
    museum = free_port()
    async with (
        sites(museum, headers=ISOLATED) as pages,
        serve(tmp_path, allowing(museum)) as server,
    ):
        frame = await line(server)
        values = WITHOUT_ORIGIN + WITH_ORIGIN
        pages["/"] = "".join(frame.replace(" ", f' sandbox="{one}" ', 1) for one in values)
        context = await chromium.new_context()
        viewer = await Viewer.at(context, server.url)  # the frame keeps that answer
        await viewer.page.goto(f"http://localhost:{museum}/")
        for index, value in enumerate(values):
            inside = viewer.page.frame_locator(f"iframe >> nth={index}")
            if value in WITHOUT_ORIGIN:
                said = inside.get_by_text("the site around this frame")
                await expect(said).to_contain_text(f"{server.url}/")
                assert await inside.get_by_role("link").count() == 0
                continue
            await expect(inside.get_by_text("the robot is free")).to_be_visible(timeout=20_000)
            part = viewer.page.frames[1 + index]
            await eventually(partial(part.evaluate, "waxProbe.playing()"), f"“{value}” plays")
            link = inside.get_by_role("link", name="Drive this robot")
            if "popups" not in value:
                await link.click()
                await expect(inside.get_by_role("link", name=server.url)).to_be_visible()
                continue
            async with context.expect_page() as opening:
                await link.click()
            opened = await opening.value
            join = opened.get_by_role("button", name="Join the queue")
            await expect(join).to_be_visible(timeout=20_000)
        await context.close()


@pytest.mark.full
async def test_firefox_shows_the_frame_without_a_cookie(serve: Serve, tmp_path: Path) -> None:
    """The picture plays and its words are there, although third parties can store nothing."""
    museum = free_port()
    async with (
        sites(museum) as pages,
        serve(tmp_path, allowing(museum)) as server,
        firefox(tmp_path, preferences=NO_COOKIE) as window,
    ):
        pages["/"] = await line(server)
        await window.goto(f"http://localhost:{museum}/")
        frame = await window.frame()
        await eventually(
            lambda: frame.evaluate("window.waxProbe?.playing() ?? false"),
            "the frame's picture plays",
            within_s=30,
        )
        await reads(frame, "the robot is free")
        assert await frame.evaluate(TRIES) == ""
