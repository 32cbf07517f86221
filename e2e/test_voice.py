"""A voice, from Chromium's microphone to the robot's speaker, and what silences it."""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio
from playwright.async_api import async_playwright, expect

from e2e.conftest import sound_device
from e2e.harness import speech, toml
from e2e.harness.chromium import launch_chromium, talkers_chromium
from e2e.harness.robot import turn_by_key
from e2e.harness.speech import HEARD_S, SPOKEN_S, are_words
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from playwright.async_api import Browser

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.measure.ear import Ear

ROBOT = """
[video]
source = "testcard"
fps = 10.0
[audio]
source = "robot"
[voice]
speaker = "robot"
"""
"""The simulated robot, whose microphone hears its speaker; few pictures, since sound is judged."""


own_ear = pytest_asyncio.fixture(sound_device, scope="module", loop_scope="session")
"""For the browser with the microphone."""


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def talking(
    tmp_path_factory: pytest.TempPathFactory, own_ear: Ear | None
) -> AsyncIterator[Browser]:
    """Launch a browser whose microphone hears real words, again and again."""
    words = tmp_path_factory.mktemp("words") / "words.wav"
    speech.write(words, speech.voice(SPOKEN_S))
    flags = (
        "--use-fake-ui-for-media-stream",
        "--use-fake-device-for-media-stream",
        f"--use-file-for-fake-audio-capture={words}",
    )
    async with (
        async_playwright() as playwright,
        await launch_chromium(playwright, *flags, ear=own_ear) as browser,
    ):
        yield browser


@pytest_asyncio.fixture(loop_scope="session")
async def server(serve: Serve, tmp_path: Path) -> AsyncIterator[Server]:
    speaker = f'speaker = "{tmp_path / "said.wav"}"'
    async with serve(tmp_path, toml.card_with(voice=speaker)) as running:
        yield running


async def enter(
    browser: Browser, server: Server, *, is_host: bool = False, ear: Ear | None = None
) -> Viewer:
    context = await browser.new_context(permissions=["microphone"])
    if is_host:
        await server.make_host(context)
    viewer = await Viewer.at(context, server.url, ear)
    await viewer.sees_picture()
    return viewer


async def test_the_operator_is_heard_until_the_key_is_released_or_the_host_mutes(
    talking: Browser, server: Server, tmp_path: Path
) -> None:
    """While they drive, the speaker plays the microphone's words, and the page says so."""
    played = tmp_path / "said.wav"
    host = await enter(talking, server, is_host=True)
    viewer = await enter(talking, server)
    is_heard = expect(viewer.page.get_by_text("You are heard."))
    assert await viewer.button("Hold to speak").count() == 0
    await viewer.takes_the_wheel()
    await viewer.page.keyboard.down("KeyT")
    await is_heard.to_be_visible(timeout=20_000)
    await are_words(lambda: speech.read(played))
    await turn_by_key(server, viewer, "ArrowUp")  # while its operator speaks
    await viewer.page.keyboard.up("ArrowUp")
    await viewer.page.keyboard.up("KeyT")
    await is_heard.to_be_hidden()
    await falls_silent(played)

    await viewer.page.keyboard.down("KeyT")
    await is_heard.to_be_visible(timeout=20_000)
    await host.button("Host").click()
    await host.switch("Mute all voices").click()
    await expect(viewer.page.get_by_text("The host has muted all voices.")).to_be_visible()
    await falls_silent(played)
    for one in (viewer, host):
        assert one.errors == []
        await one.page.context.close()


async def test_whoever_may_speak_is_bound_to_no_address(server: Server) -> None:
    """A page that may use the microphone offers no address: a browser binds to those it offers."""
    async with (
        async_playwright() as playwright,
        talkers_chromium(playwright, server.url.rstrip("/")) as context,
    ):
        viewer = await Viewer.at(context, server.url)
        await viewer.sees_picture()
        permission = "navigator.permissions.query({name: 'microphone'})"
        assert await viewer.page.evaluate(f"{permission}.then(({{state}}) => state)") == "granted"
        offered = re.findall(r"^a=candidate:(.*)", await viewer.probe("offer()"), re.MULTILINE)
        assert offered
        assert all(one.split()[4].endswith(".local") for one in offered)


async def falls_silent(played: Path) -> None:
    """Wait until nothing more is played for a second; a busy browser sends late."""

    async def is_silent() -> bool:
        before = len(speech.read(played))
        await asyncio.sleep(1)
        return len(speech.read(played)) == before

    await eventually(is_silent, "nothing more is played", within_s=20)


@pytest.mark.full
async def test_who_speaks_does_not_hear_the_robot(
    talking: Browser, own_ear: Ear | None, open_viewer: OpenViewer, serve: Serve, tmp_path: Path
) -> None:
    """The speaker hears no echo, as the page says, while an observer hears their words."""
    async with serve(tmp_path, ROBOT) as server:
        viewer = await enter(talking, server, ear=own_ear)
        await viewer.takes_the_wheel()
        await viewer.listen()
        watcher = await open_viewer(server)
        await watcher.listen()
        await expect(viewer.page.get_by_text("you do not hear the robot")).to_be_visible()
        await viewer.page.keyboard.down("KeyT")
        await expect(viewer.page.get_by_text("You are heard.")).to_be_visible(timeout=20_000)
        viewer.forget()
        watcher.forget()
        await are_words(watcher.sound)
        assert len(viewer.heard()) >= HEARD_S * 50  # of 100 blocks a second
        assert max(block.rms for block in viewer.heard()) == 0
        await viewer.page.keyboard.up("KeyT")
        viewer.forget()
        await until(lambda: any(block.rms > 0 for block in viewer.heard()), "it is heard again")
        assert viewer.errors == []
        await viewer.page.context.close()
