"""The page's built-in player, as it sounds outside, and the fallback to the browser's."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from e2e.harness import probe, toml
from e2e.harness.viewer import BROWSER, OWN, plays_by
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from playwright.async_api import Route

    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server

SERVER_SETTINGS = toml.FEW_PICTURES

FALLS_BACK_WITHIN_MS = 300.0

FAILING_DECODER = """
const decode = AudioDecoder.prototype.decode;
let left = 150;
AudioDecoder.prototype.decode = function (chunk) {
  if (left-- < 0) throw new DOMException("the decoder has failed", "EncodingError");
  decode.call(this, chunk);
};
"""


@pytest.mark.timeout(120)
@pytest.mark.full
async def test_a_page_that_is_busy_or_behind_plays_on(
    server: Server, open_viewer: OpenViewer
) -> None:
    """No gap is heard while the main thread is blocked four times, nor for 15 s in a hidden tab."""
    viewer = await open_viewer(server)
    await viewer.listen()
    await plays_by(viewer, OWN)
    await asyncio.sleep(3)
    viewer.forget()
    for _ in range(4):
        await viewer.page.evaluate(
            "const end = performance.now() + 800; while (performance.now() < end);"
        )
        await asyncio.sleep(0.3)
    assert probe.gaps_ms(viewer.heard()) == []
    cdp = await viewer.page.context.new_cdp_session(viewer.page)
    # A page that is driven counts as seen, whatever covers it.
    await cdp.send("Emulation.setFocusEmulationEnabled", {"enabled": False})
    window = (await cdp.send("Browser.getWindowForTarget"))["windowId"]
    bounds = {"windowId": window, "bounds": {"windowState": "minimized"}}
    await cdp.send("Browser.setWindowBounds", bounds)
    await eventually(lambda: viewer.probe("isBehind()"), "it is behind")
    viewer.forget()
    await asyncio.sleep(15)
    assert probe.gaps_ms(viewer.heard()) == []
    await plays_by(viewer, OWN)


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_decoder_that_fails_is_hardly_heard(
    server: Server, open_viewer: OpenViewer
) -> None:
    """The browser's player takes over within 300 ms, and the page says why."""

    async def failing(route: Route) -> None:
        answer = await route.fetch()
        text = await answer.text()
        broken = f"{FAILING_DECODER}{text}" if "AudioDecoder" in text else text
        await route.fulfill(response=answer, body=broken)

    viewer = await open_viewer(server)
    await viewer.page.context.route("**/assets/playerWorker-*.js", failing)
    await viewer.page.reload()
    await viewer.sees_picture()
    await viewer.listen()
    await plays_by(viewer, OWN)
    viewer.forget()
    await plays_by(viewer, BROWSER)
    await asyncio.sleep(1)
    heard = viewer.heard()
    assert max(probe.gaps_ms(heard), default=0.0) <= FALLS_BACK_WITHIN_MS
    assert probe.loudness(heard[-50:]) > 0.02
    assert "the decoder has failed" in await viewer.page.evaluate("document.body.textContent")
