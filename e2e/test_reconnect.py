"""What a reload, a lost page and a restarted server do."""

from __future__ import annotations

import asyncio
import os
import signal
from typing import TYPE_CHECKING

import pytest

from e2e.harness import toml
from e2e.harness.probe import assert_live
from e2e.harness.robot import moves, stands_still, turn_by_key
from e2e.harness.wait import eventually
from wax.clock import SystemClock
from wax.commands.proof.remote import RemoteOperator

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

pytestmark = pytest.mark.timeout(90)

GRACE_S = 3.0


SERVER_SETTINGS = toml.card_with(turns=f"grace_s = {GRACE_S}")


async def test_a_reload_keeps_turn_place_and_name(server: Server, open_viewer: OpenViewer) -> None:
    """The operator who reloads drives the same turn, by a new press; a key held over it is dead."""
    ada, bob = await open_viewer(server), await open_viewer(server)
    await ada.call_oneself("Ada")
    await bob.call_oneself("Bob")
    await ada.takes_the_wheel()
    await bob.join()
    number = (await server.status())["turn"]["number"]
    await turn_by_key(server, ada)
    await ada.page.reload()
    assert await stands_still(server)
    await bob.page.reload()
    for viewer in (ada, bob):
        await viewer.sees_picture()
    await ada.drives()
    assert not await moves(server, during_s=1)
    after = await server.status()
    assert after["turn"]["number"] == number
    roles = {line["name"]: (line["role"], line["place"]) for line in after["viewers"]}
    assert roles == {"Ada": ("operator", 0), "Bob": ("queued", 1)}
    await ada.page.keyboard.up("ArrowLeft")
    await turn_by_key(server, ada)
    await ada.page.keyboard.up("ArrowLeft")


async def test_a_lost_operator_is_replaced_after_the_grace(
    server: Server, open_viewer: OpenViewer
) -> None:
    """A viewer who stays away loses the turn when the grace time ends, not before."""
    ada, carol = await open_viewer(server), await open_viewer(server)
    await carol.call_oneself("Carol")
    await ada.takes_the_wheel()
    await carol.join()
    await ada.page.goto("about:blank")
    await asyncio.sleep(GRACE_S / 3)
    roles = {line["role"] for line in (await server.status())["viewers"] if line["name"] == "Carol"}
    assert roles == {"queued"}
    await carol.drives(within_s=GRACE_S + 3)


@pytest.mark.timeout(120)
@pytest.mark.full
async def test_a_restarted_server_is_found_again(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """The page says that the server ends; when it is back, so is the page, with its name."""
    async with serve(tmp_path, toml.CARD) as server:
        viewer = await open_viewer(server)
        await viewer.call_oneself("Ada")
        peers = await viewer.probe("peers()")
        await eventually(viewer.says_connected, "the page says that it is connected")
        await viewer.page.evaluate(_NOTE_CHANGE)
        await server.stop(signal.SIGTERM)
        _, said = await says_next(viewer)
        assert "The server is restarting or was switched off." in said
        await server.start()

        async def fresh() -> bool:
            return bool(
                await viewer.probe("peers()") > peers
                and await viewer.probe("state()") == "connected"
            )

        await eventually(fresh, "a fresh peer is connected", within_s=20)
        await eventually(viewer.says_connected, "the page says that it is connected")
        assert [line["name"] for line in (await server.status())["viewers"]] == ["Ada"]
        await viewer.sees_picture()
        assert_live(await viewer.cards(20))
        await viewer.takes_the_wheel()
        await turn_by_key(server, viewer)
        await viewer.page.keyboard.up("ArrowLeft")


_NOTE_CHANGE = """() => {
  const status = document.querySelector('[role="status"]');
  window.waxSaid = new Promise((resolve) => {
    new MutationObserver(() => resolve([Date.now(), status.textContent])).observe(
      status, { characterData: true, childList: true, subtree: true });
  });
}"""
_IS_GREY = (
    """() => getComputedStyle(document.querySelector('video')).filter.includes('grayscale')"""
)
SAID_WITHIN_MS = 1000
"""A safety deadline: the operator must not mistake an old picture for a live one."""


async def says_next(viewer: Viewer) -> tuple[float, str]:
    """Return when the page next said something else of the connection, as Unix time, and what."""
    at_ms, text = await viewer.page.evaluate("window.waxSaid")
    return at_ms, text


@pytest.mark.timeout(120)
async def test_a_server_that_is_gone_is_told_within_a_second_and_found_again(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """Paused it is not called lost; killed, the operator sees the picture grey until it is back."""
    async with serve(tmp_path, toml.CARD) as server:
        viewer = await open_viewer(server, drives=True)
        await asyncio.sleep(3)  # until the page pings as seldom as it ever does
        peers = await viewer.probe("peers()")
        for end in (signal.SIGSTOP, signal.SIGKILL):
            assert not await viewer.page.evaluate(_IS_GREY)
            await viewer.page.evaluate(_NOTE_CHANGE)
            ended_ms = SystemClock().wall_ms()
            os.kill(server.pid, end)
            at_ms, said = await says_next(viewer)
            assert said == "No answer for 1 s"
            assert await viewer.page.evaluate(_IS_GREY)
            assert at_ms - ended_ms < SAID_WITHIN_MS
            await viewer.page.get_by_text("Not live: the server is not answering.").wait_for()
            if end == signal.SIGSTOP:
                os.kill(server.pid, signal.SIGCONT)
                await eventually(viewer.says_connected, "the page says that it is connected")
                assert await viewer.probe("peers()") == peers
                await asyncio.sleep(3)
        await server.kill()
        await server.start()
        await server.until(lambda told: len(told["viewers"]) == 1, "the page is back", within_s=25)
        await eventually(lambda: viewer.probe("playing()"), "the picture plays", within_s=10)
        assert_live(await viewer.cards(20))


async def test_a_killed_client_comes_back_as_itself(serve: Serve, tmp_path: Path) -> None:
    """The proof's operator, killed and started again, has the turn that it had."""
    patient = toml.card_with(turns="grace_s = 20.0")
    async with serve(tmp_path, patient) as server:
        operator = RemoteOperator(tmp_path / "operator.log")
        try:
            await operator.start(server.url)
            operator.tell("join")
            assert await operator.until(lambda: operator.state.drives, 10)
            turn = operator.state.turn
            await operator.kill()
            await operator.start(server.url)
            assert await operator.until(lambda: operator.state.drives, 10)
            assert operator.state.turn == turn
        finally:
            await operator.kill()
