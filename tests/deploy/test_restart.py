"""A restart says goodbye to everybody, and everybody who returns has the same place."""

from __future__ import annotations

import asyncio
import signal
import socket
from functools import partial
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from tests.deploy.running import STOP_WITHIN_S, answers, serving
from tests.free_port import free_port

from wax.client import Client

if TYPE_CHECKING:
    from pathlib import Path

    from wax.capture.source import Picture
    from wax.clock import Clock
    from wax.config.video import VideoSettings

pytestmark = pytest.mark.system


CARD = '[video]\nsource = "testcard"\nwidth = 640\nheight = 480\n[audio]\nsource = "testcard"\n'


async def test_a_restart_says_goodbye_and_takes_everybody_back(tmp_path: Path) -> None:
    """After SIGTERM the goodbye comes before the end; on the same port the name comes back."""
    config = tmp_path / "wax.toml"
    config.write_text(CARD)
    port = free_port()
    url = f"http://127.0.0.1:{port}"
    async with serving(config, port) as server:
        await answers(port, server)
        async with Client(url, name="Ada") as ada:
            assert await ada.until(lambda: _names(ada) == ["Ada"])
            server.send_signal(signal.SIGTERM)
            assert await ada.until(lambda: bool(ada.newest("goodbye")))
            assert ada.newest("goodbye")["text"] == {"code": "door.goodbye"}
            assert await ada.until(lambda: not ada.is_open)
            assert await asyncio.wait_for(server.wait(), STOP_WITHIN_S) == 0
    async with serving(config, port) as server:
        await answers(port, server)
        async with Client(url, name="Ada", client_id=ada.client_id, cookies=ada.cookies) as back:
            assert await back.until(lambda: _names(back) == ["Ada"])


class Hung:
    """A camera that never opens, because a C++ library hangs."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None: ...

    def open(self) -> None:
        picture = np.zeros((1000, 1000), np.uint8)
        while True:
            cv2.GaussianBlur(picture, (31, 31), 0)

    def read(self) -> Picture:
        raise AssertionError

    def close(self) -> None: ...


async def test_a_service_manager_follows_the_server(tmp_path: Path) -> None:
    """READY comes when the page can be opened, then signs of life, and STOPPING at the end.

    Although a camera hangs, the server ends in order and does not crash.
    """
    config = tmp_path / "wax.toml"
    config.write_text(
        '[video]\nsource = "tests.deploy.test_restart:Hung"\n[audio]\nsource = "none"\n'
    )
    port = free_port()
    environment = {"NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "300000"}
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(environment["NOTIFY_SOCKET"])
        listening.setblocking(False)
        hear = partial(asyncio.get_running_loop().sock_recv, listening, 99)
        async with serving(config, port, environment=environment) as server:
            while (heard := await hear()) == b"WATCHDOG=1":
                pass
            assert heard == b"READY=1"
            await answers(port, server)
            assert [await hear(), await hear()] == [b"WATCHDOG=1"] * 2
            server.send_signal(signal.SIGTERM)
            while (heard := await hear()) == b"WATCHDOG=1":
                pass
            assert heard == b"STOPPING=1"
            assert await asyncio.wait_for(server.wait(), STOP_WITHIN_S) == 0


def _names(client: Client) -> list[str]:
    return [viewer["name"] for viewer in client.newest("room").get("viewers", [])]
