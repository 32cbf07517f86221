"""What the page loads before it shows anything, and from where."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pytest

from e2e.harness import toml
from e2e.harness.viewer import OWN, Viewer, plays_by
from e2e.harness.wait import until
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from playwright.async_api import Browser

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

BUDGET_BYTES: Final = 75_000
FIRST: Final = {"first", "playerWorker"}
"""The parts that everybody needs at once; any other is for some people, or for later."""
HOST: Final = re.compile(
    r"""["'`(](?:https?:|wss?:)?//([a-z0-9-]+(?:\\?\.[a-z0-9-]+)+)""", re.IGNORECASE
)
NAMESPACES: Final = {"www.w3.org"}
"""A name that identifies a format such as SVG, and to which no request is ever sent."""
DIST: Final = ROOT / "server/wax/web/dist"


async def test_little_is_loaded_before_the_first_picture(chromium: Browser, server: Server) -> None:
    """Page, scripts and styles are 75 kB as transferred, and none of that is needed only later."""
    async with await chromium.new_context(locale="en-GB") as context:
        viewer = await Viewer.at(context, server.url)
        loaded = await viewer.probe("loadedFirst('/sentences-')")
    sizes = {one["name"].removeprefix(server.url): one["encodedBodySize"] for one in loaded}
    assert "/" in sizes
    # A part is called name-hash.js, with a hash of 8 characters.
    assets = [name for name in sizes if name.startswith("/assets/")]
    assert {Path(name).stem[:-9] for name in assets} == FIRST, sizes
    assert sum(sizes.values()) <= BUDGET_BYTES, sizes


async def test_everything_loaded_is_the_servers_own_and_within_its_policy(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Every request goes to the page's server, none is refused, and one worker is preloaded."""
    viewer = await open_viewer(server)
    asked: list[str] = []
    viewer.page.on("request", lambda request: asked.append(request.url))
    await viewer.page.reload()
    await viewer.sees_picture()
    await viewer.button("Turn sound on").click()
    await plays_by(viewer, OWN)
    assert asked
    assert all(url.startswith((server.url, "blob:", "data:")) for url in asked), asked
    said = ("Content Security Policy", "Permissions-Policy", "Permissions policy", "Opener-Policy")
    assert not [line for line in viewer.console if any(name in line for name in said)]
    assert not [line for line in viewer.console if line.startswith("error:")], viewer.console
    ahead: list[str] = await viewer.page.evaluate(
        "Array.from(document.querySelectorAll('link[rel=modulepreload]'), (link) => link.href)"
    )
    started = {worker.url for worker in viewer.page.workers}
    assert started, "the page has started no worker"
    assert started <= set(ahead), ahead
    assert len([url for url in ahead if "orker" in url]) == 1, ahead


@pytest.mark.full
async def test_it_works_below_a_path(chromium: Browser, serve: Serve, tmp_path: Path) -> None:
    """Behind a proxy that strips a path, the page connects, shows the robot and stops it."""
    below, asked = "http://robot.example/robot", list[str]()
    async with (
        serve(tmp_path, toml.CARD) as server,
        await chromium.new_context(locale="en-GB") as context,
    ):
        viewer = await Viewer.prepare(context, server.url)
        viewer.page.on("request", lambda request: asked.append(request.url))
        await viewer.is_reached_as(below)
        await viewer.page.goto(f"{below}/")
        await viewer.sees_picture()
        await viewer.page.get_by_role("button", name="Stop", exact=True).first.click()
        await until(lambda: f"{below}/api/stop" in asked, "the stop is asked for")
    assert all(url.startswith((f"{below}/", "blob:", "data:")) for url in asked), asked


def test_no_other_host_is_named_in_it() -> None:
    """The text of page, scripts and styles contains no address of anybody else."""
    page = (DIST / "index.html").read_text(encoding="utf-8")
    names = re.findall(r'(?:src|href)="\./(assets/[^"]+)"', page)
    assert [name for name in names if name.endswith(".js")], page
    for text in (page, *((DIST / name).read_text(encoding="utf-8") for name in names)):
        assert set(HOST.findall(text)) <= NAMESPACES
