"""LiveKit as a peer: what a browser gets, and how it ends."""

from __future__ import annotations

import asyncio
import signal
import sys
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import psutil
import pytest
from tests.free_port import free_port

from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.measure.errors import NotRunError
from e2e.measure.suite import ROOT
from e2e.peers.livekit.installation import find_client, find_server
from e2e.peers.sizes import SIZES

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator
    from pathlib import Path

    from playwright.async_api import Browser

    from e2e.peers.sizes import SizeName

pytestmark = pytest.mark.timeout(90)


@asynccontextmanager
async def started(how: str = "sdk", size: SizeName = "640x480") -> AsyncIterator[Process]:
    """Start it on free ports, where it is installed; at the end its leftovers are killed."""
    find_server()
    find_client()
    page, *own = (str(free_port()) for _ in range(4))
    asked = ("--how", how, "--size", size, "--port", page, "--ports", *own)
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "e2e.peers.livekit", *asked),
        cwd=ROOT,
        stdout=PIPE,
        stderr=PIPE,
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            for child in psutil.Process(process.pid).children(recursive=True):
                child.kill()
            process.kill()
            await process.wait()


async def url_of(process: Process) -> str:
    assert process.stdout is not None
    line = await asyncio.wait_for(process.stdout.readline(), 40)
    return line.decode().strip()


async def refusal(process: Process) -> str:
    """Wait until it has ended with status 1; return the sentences that say why, and the SDK's."""
    _, said = await asyncio.wait_for(process.communicate(), 40)
    assert process.returncode == 1
    return said.decode()


async def test_what_is_no_livekit_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It names a program that ends at once, and the value of a variable that names no program."""
    program = tmp_path / "livekit-server"
    program.write_text("#!/bin/sh\nexit 3\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("WAX_LIVEKIT", str(program))
    async with started() as process:
        assert "LiveKit ended at its start with status 3" in await refusal(process)
    monkeypatch.setenv("WAX_LIVEKIT", str(tmp_path))
    with pytest.raises(NotRunError, match=f"WAX_LIVEKIT names no program: {tmp_path}"):
        find_server()


async def test_when_livekit_dies_the_rest_ends() -> None:
    """A killed LiveKit is reported in one sentence, and nothing of this peer stays."""
    async with started() as process:
        assert (await url_of(process)).startswith("http://127.0.0.1:")
        family = psutil.Process(process.pid).children(recursive=True)
        next(child for child in family if child.name() == find_server().name).kill()
        assert "LiveKit ended with status -9" in await refusal(process)
        assert not [child for child in family if child.is_running()]


@pytest.mark.parametrize(("how", "size"), [("sdk", "640x480"), ("whip", "1280x720")])
async def test_a_browser_sees_and_hears_through_livekit(
    chromium: Browser, how: str, size: SizeName
) -> None:
    """The test card arrives whole, and so do packets of sound; Ctrl-C leaves no process."""
    async with started(how, size) as process:
        url = await url_of(process)
        family = psutil.Process(process.pid).children(recursive=True)
        assert len(family) == 1  # LiveKit; publisher and page are the parent's
        context = await chromium.new_context()
        try:
            viewer = await Viewer.prepare(context, url)
            await viewer.page.goto(url)
            await viewer.sees_picture()
            cards = await viewer.cards(20)
            assert sum(card.valid for card in cards) >= 18
            assert {(card.width, card.height) for card in cards} == {SIZES[size][:2]}
            assert len({card.stamp_ms for card in cards}) >= 18

            async def hears() -> bool:
                return await viewer.packets("audio") > 50

            await eventually(hears, "packets of sound arrive")
            assert await viewer.says_connected()
            assert viewer.errors == []
        finally:
            await context.close()
        process.send_signal(signal.SIGINT)
        assert await asyncio.wait_for(process.wait(), 10) == 0
        assert not [child for child in family if child.is_running()]
