"""Friends in other networks reach the robot: by one forwarded port, or by a relay."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import aiohttp
import pytest
from playwright.async_api import async_playwright

from e2e.harness.chromium import FLAGS, find_chromium
from e2e.harness.missing import missing
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.lab.link import UnavailableError
from e2e.lab.relay import http_through
from e2e.reach.internet import Internet
from e2e.reach.packet import TCP, UDP
from e2e.reach.router import Host
from e2e.reach.turnserver import PORT, TurnServer
from wax.client.host import become_host

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

HTTP, MEDIA = 8080, 8081
ROBOT: Final = Host(
    "robot", "192.168.1.2", public="203.0.113.1", forwards=((TCP, HTTP), (UDP, MEDIA))
)
FRIEND: Final = Host("friend", "192.168.7.2", public="203.0.113.2")
OFFICE: Final = Host("friend", "10.1.1.2", public="203.0.113.3", udp=False)
TURN: Final = Host("turn", "203.0.113.9")
SECRET: Final = "shared by robot and relay"
URL: Final = f"http://{ROBOT.public}:{HTTP}"
BASE: Final = f"""
[server]
host = "0.0.0.0"
port = {HTTP}
state_dir = "{{state}}"
[network]
udp_port = {MEDIA}
public_addresses = ["{ROBOT.public}"]
[audio]
source = "none"
"""


class Stage:
    """A robot that serves, and the browser of a friend elsewhere."""

    def __init__(self, net: Internet, http: aiohttp.ClientSession, viewer: Viewer) -> None:
        self.net = net
        self.viewer = viewer
        self._http = http

    async def status(self) -> dict[str, Any]:
        async with self._http.get("http://localhost/api/status") as answer:
            status: dict[str, Any] = await answer.json()
            return status

    async def drives(self) -> None:
        """Join the queue, hold a key, and see the robot move."""
        if not await self.viewer.page.get_by_text("You are driving").first.is_visible():
            await self.viewer.join()
            await self.viewer.drives()

        async def moves() -> bool:
            await self.viewer.page.keyboard.down("ArrowUp")
            before = (await self.status())["robot"]["pose"]
            await asyncio.sleep(0.6)
            after = (await self.status())["robot"]["pose"]
            await self.viewer.page.keyboard.up("ArrowUp")
            return bool(
                abs(after["x_m"] - before["x_m"]) + abs(after["y_m"] - before["y_m"]) > 0.02
            )

        await eventually(moves, "the robot moves")

    async def sees(self) -> dict[str, str]:
        """Wait until pictures go on coming; return by which way."""
        before = await self._pictures()

        async def path() -> dict[str, str] | None:
            if await self._pictures() < before + 5:
                return None
            found: dict[str, str] | None = await self.viewer.probe("path()")
            return found

        return await eventually(path, "pictures come", within_s=20) or {}

    async def _pictures(self) -> float:
        return float((await self.viewer.inbound("video")).get("framesDecoded", 0))


@asynccontextmanager
async def staged(
    folder: Path, toml: str, *hosts: Host, relay: TurnServer | None = None
) -> AsyncIterator[Stage]:
    """Serve the robot at its end and open the page at the friend's."""
    try:
        net = await Internet(*hosts).__aenter__()
    except UnavailableError as error:
        missing(str(error))
    try:
        if relay is not None:
            await relay.start(net, folder)
        config = folder / "wax.toml"
        config.write_text(toml.format(state=folder / "state"), encoding="utf-8")
        with (folder / "server.log").open("wb") as log:
            await net["robot"].spawn_python(
                ["-m", "wax", "--config", str(config)],
                stdin=asyncio.subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )
        async with http_through(net["robot"], "127.0.0.1", HTTP) as http:

            async def serves() -> bool:
                try:
                    async with http.get("http://localhost/healthz") as answer:
                        return answer.status == 200
                except aiohttp.ClientError:
                    return False

            await eventually(serves, "the server serves", within_s=20)
            await become_host(http, "http://localhost", folder / "state")
            async with _page(net, folder) as viewer:
                yield Stage(net, http, viewer)
    except BaseException:
        _tell_logs(folder)
        raise
    finally:
        await net.__aexit__()


def _tell_logs(folder: Path) -> None:
    for path in folder.glob("*.log"):
        print(f"{path.name}:\n{path.read_text(encoding='utf-8', errors='replace')[-4000:]}")


@asynccontextmanager
async def _page(net: Internet, folder: Path) -> AsyncIterator[Viewer]:
    launcher = net["friend"].launcher(folder / "chromium", find_chromium())
    flags = [*FLAGS, "--no-sandbox", f"--unsafely-treat-insecure-origin-as-secure={URL}"]
    # No name server answers there, so nothing else is looked up.
    known = f"EXCLUDE {ROBOT.public}, EXCLUDE {TURN.address}"
    flags.append(f"--host-resolver-rules=MAP * ~NOTFOUND, {known}")
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=launcher, headless=True, args=flags
        )
        try:
            context = await browser.new_context()
            viewer = await Viewer.prepare(context, URL)
            await viewer.page.goto(URL)
            yield viewer
        finally:
            await browser.close()


def by_relay(url: str, *more: str) -> str:
    """Write a configuration with a relay."""
    return "\n".join([BASE, "[relay]", f'urls = ["{url}"]', f'secret = "{SECRET}"', *more])


async def test_one_forwarded_port_is_enough(tmp_path: Path) -> None:
    """A friend behind another NAT sees the picture and drives, also after their router forgot."""
    async with staged(tmp_path, BASE, ROBOT, FRIEND) as stage:
        assert (await stage.sees())["to"] == f"{ROBOT.public}:{MEDIA}"
        await stage.drives()
        stage.net.forget("friend")
        await asyncio.sleep(0.2)  # what was under way
        assert (await stage.sees())["to"] == f"{ROBOT.public}:{MEDIA}"
        await stage.drives()


async def test_a_relay_helps_where_no_udp_gets_out(tmp_path: Path) -> None:
    """From an office that lets no UDP out a friend drives by TURN over TCP, by our coturn."""
    toml = by_relay(f"turn:{TURN.address}:{PORT}?transport=tcp")
    coturn = TurnServer(TURN, SECRET, to=ROBOT)
    async with staged(tmp_path, toml, ROBOT, OFFICE, TURN, relay=coturn) as stage:
        way = {"type": "relay", "relay": "tcp", "to": f"{ROBOT.public}:{MEDIA}"}
        assert await stage.sees() == way
        await stage.drives()


@pytest.mark.full
async def test_relay_only_uses_nothing_else(tmp_path: Path) -> None:
    """Even where a direct connection is possible."""
    toml = by_relay(f"turn:{TURN.address}:{PORT}", "only = true")
    coturn = TurnServer(TURN, SECRET, to=ROBOT)
    async with staged(tmp_path, toml, ROBOT, FRIEND, TURN, relay=coturn) as stage:
        assert (await stage.sees())["type"] == "relay"
        await stage.drives()


@pytest.mark.full
async def test_without_a_forwarded_port_full_ice_helps(tmp_path: Path) -> None:
    """Both routers are opened from inside, by what a STUN server tells each end."""
    toml = BASE.replace(f"udp_port = {MEDIA}", 'mode = "full-ice"').replace(
        f'public_addresses = ["{ROBOT.public}"]', f'stun = ["stun:{TURN.address}:{PORT}"]'
    )
    toml = toml.replace("[server]", f'[server]\nnames = ["{ROBOT.public}"]')
    closed = replace(ROBOT, forwards=((TCP, HTTP),))
    coturn = TurnServer(TURN, SECRET, to=ROBOT)
    async with staged(tmp_path, toml, closed, FRIEND, TURN, relay=coturn) as stage:
        assert (await stage.sees())["to"].startswith(f"{ROBOT.public}:4")
        await stage.drives()
