"""The page's built-in player, as it leaves the browser, and its way back to the browser's."""

from __future__ import annotations

import asyncio
import signal
from statistics import median
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import audio_probe, toml
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from playwright.async_api import Route

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

OWN, BROWSER = "WAX's own", "the browser's"
LONGEST_GAP_MS = 60.0
"""A change of players is at most a click, of which concealment leaves a block or two."""

FALLS_BACK_WITHIN_MS = 300.0

FAILING_DECODER = """
const decode = AudioDecoder.prototype.decode;
let left = 150;
AudioDecoder.prototype.decode = function (chunk) {
  if (left-- < 0) throw new DOMException("the decoder has failed", "EncodingError");
  decode.call(this, chunk);
};
"""
IS_BEHIND = """new Promise((done) => {
  let frames = 0;
  const count = () => { frames++; requestAnimationFrame(count); };
  count();
  setTimeout(() => done(frames < 5), 1000);
})"""
KEPT_CONTEXTS = """
const made = [];
window.contexts = made;
window.AudioContext = class extends AudioContext {
  constructor(options) { super(options); made.push(this); }
};
"""


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    async with serve(tmp_path_factory.mktemp("player"), toml.CARD) as running:
        yield running


async def plays_by(viewer: Viewer, player: str) -> None:
    """Wait until the page says so."""

    async def says() -> bool:
        await viewer.open("Details")
        text = await viewer.page.evaluate("document.body.textContent")
        return f"Sound player{player}" in text

    await eventually(says, f"{player} player plays", within_s=10)


async def choose(viewer: Viewer, option: str) -> None:
    await viewer.open("Details")
    await viewer.page.get_by_role("combobox", name="Play sound by").select_option(option)


async def opened(open_viewer: OpenViewer, server: Server) -> Viewer:
    """Open a page whose sound the built-in player has played for a while."""
    viewer = await open_viewer(server)
    await viewer.listen()
    await plays_by(viewer, OWN)
    await asyncio.sleep(3)
    return viewer


async def age_ms(viewer: Viewer) -> float:
    """How old the sound is at the ear, median over six bursts."""
    viewer.forget()
    await asyncio.sleep(6)
    return median(audio_probe.burst_ages_ms(viewer.heard()))


@pytest.mark.full
@pytest.mark.timeout(120)
async def test_it_plays_by_itself_and_is_heard_sooner(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Nobody chooses anything; the browser's player, chosen then, is heard later, without a gap."""
    viewer = await opened(open_viewer, server)
    own_ms = await age_ms(viewer)
    own = viewer.heard()
    assert 0.02 < median(block.tone for block in own) < 0.1
    assert sum(audio_probe.gaps_ms(own)) <= LONGEST_GAP_MS
    viewer.forget()
    await choose(viewer, "browser")
    await plays_by(viewer, BROWSER)
    await asyncio.sleep(1)
    changed = viewer.heard()
    assert max(audio_probe.gaps_ms(changed), default=0.0) <= LONGEST_GAP_MS
    assert audio_probe.loudness(changed[-50:]) > 0.02
    assert own_ms < await age_ms(viewer)
    viewer.forget()
    await choose(viewer, "built-in")
    await plays_by(viewer, OWN)
    await asyncio.sleep(1)
    assert max(audio_probe.gaps_ms(viewer.heard()), default=0.0) <= LONGEST_GAP_MS


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_a_page_that_is_busy_does_not_break_the_sound(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Nothing of the player is on the main thread: blocked four times for 0.8 s, no gap."""
    viewer = await opened(open_viewer, server)
    viewer.forget()
    for _ in range(4):
        await viewer.page.evaluate(
            "const end = performance.now() + 800; while (performance.now() < end);"
        )
        await asyncio.sleep(0.3)
    assert audio_probe.gaps_ms(viewer.heard()) == []
    await plays_by(viewer, OWN)


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_a_tab_in_the_background_plays_on(server: Server, open_viewer: OpenViewer) -> None:
    """Where nobody sees it a page is hardly drawn; no gap is heard for 15 s."""
    viewer = await opened(open_viewer, server)
    cdp = await viewer.page.context.new_cdp_session(viewer.page)
    # A page that is driven counts as seen, whatever lies over it.
    await cdp.send("Emulation.setFocusEmulationEnabled", {"enabled": False})
    window = (await cdp.send("Browser.getWindowForTarget"))["windowId"]
    bounds = {"windowId": window, "bounds": {"windowState": "minimized"}}
    await cdp.send("Browser.setWindowBounds", bounds)
    await eventually(lambda: viewer.page.evaluate(IS_BEHIND), "it is behind")
    viewer.forget()
    await asyncio.sleep(15)
    assert audio_probe.gaps_ms(viewer.heard()) == []
    await plays_by(viewer, OWN)


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_decoder_that_fails_is_hardly_heard(
    server: Server, open_viewer: OpenViewer
) -> None:
    """The browser's player goes on within 300 ms, and the page says why."""

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
    assert max(audio_probe.gaps_ms(heard), default=0.0) <= FALLS_BACK_WITHIN_MS
    assert audio_probe.loudness(heard[-50:]) > 0.02
    assert "the decoder has failed" in await viewer.page.evaluate("document.body.textContent")


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_device_that_stops_is_hardly_heard(server: Server, open_viewer: OpenViewer) -> None:
    """A context that is suspended from outside: the browser's player goes on, ours comes back."""
    viewer = await open_viewer(server)
    await viewer.page.add_init_script(KEPT_CONTEXTS)
    await viewer.page.reload()
    await viewer.sees_picture()
    await viewer.listen()
    await plays_by(viewer, OWN)
    await asyncio.sleep(2)
    viewer.forget()
    await viewer.page.evaluate("Promise.all(window.contexts.map((one) => one.suspend()))")
    await plays_by(viewer, BROWSER)
    await asyncio.sleep(1)
    heard = viewer.heard()
    # Until the device is missed nothing sounds: 250 ms, and the browser's player has to fill.
    assert max(audio_probe.gaps_ms(heard), default=0.0) <= 2 * FALLS_BACK_WITHIN_MS
    assert audio_probe.loudness(heard[-50:]) > 0.02
    await plays_by(viewer, OWN)


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_it_plays_on_over_a_new_connection(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """When the server is back, the sound is the built-in player's again, without a touch."""
    async with serve(tmp_path, toml.CARD) as server:
        viewer = await open_viewer(server)
        await viewer.listen()
        await plays_by(viewer, OWN)
        await server.stop(signal.SIGTERM)
        await asyncio.sleep(1)
        viewer.forget()
        await server.start()
        await eventually(lambda: sounds(viewer), "it sounds again", within_s=15)
        await asyncio.sleep(2)
        viewer.forget()
        await asyncio.sleep(2)
        assert audio_probe.gaps_ms(viewer.heard()) == []
        await plays_by(viewer, OWN)


async def sounds(viewer: Viewer) -> bool:
    return any(block.tone > 0.02 for block in viewer.heard())
