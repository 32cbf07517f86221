"""Friends in other networks reach the robot: by one forwarded port, or by a relay."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from playwright.async_api import async_playwright

from e2e.harness.viewer import Viewer
from e2e.reach.internet import Host, Internet
from e2e.reach.stage import FRIEND, HTTP, MEDIA, ROBOT, TURN, URL, Stage, browser_at, serving
from e2e.reach.turnserver import PORT, SECRET, relay

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path


OFFICE: Final = Host("friend", "10.1.1.2", public="203.0.113.3", udp=False)
BASE: Final = f"""
[server]
state_dir = "{{state}}"
[network]
udp_port = {MEDIA}
public_addresses = ["{ROBOT.public}"]
[audio]
source = "none"
"""


@asynccontextmanager
async def staged(folder: Path, toml: str, *hosts: Host) -> AsyncIterator[Stage]:
    """Serve the robot at its host and open the page at the friend's, with a relay on `TURN`."""
    async with Internet(*hosts) as net:
        if TURN in hosts:
            await relay(net, folder)
        async with (
            serving(net, folder, toml.format(state=folder / "state")) as robot,
            async_playwright() as playwright,
            browser_at(net, "friend", playwright) as browser,
        ):
            viewer = await Viewer.at(await browser.new_context(), URL)
            yield Stage(net, robot, viewer)


def by_relay(url: str, *more: str) -> str:
    return "\n".join([BASE, "[relay]", f'urls = ["{url}"]', f'secret = "{SECRET}"', *more])


async def test_one_forwarded_port_is_enough(tmp_path: Path) -> None:
    """A friend behind another NAT drives, with the same peer even after their router restarted."""
    friend = replace(FRIEND, symmetric=True)
    async with staged(tmp_path, BASE, ROBOT, friend) as stage:
        assert (await stage.sees())["to"] == f"{ROBOT.public}:{MEDIA}"
        await stage.drives()
        peers = await stage.viewer.probe("peers()")
        await stage.net.forget("friend")
        await asyncio.sleep(0.2)  # what was in flight
        assert (await stage.sees())["to"] == f"{ROBOT.public}:{MEDIA}"
        assert await stage.viewer.probe("peers()") == peers
        await stage.drives()


async def test_a_relay_helps_where_no_udp_gets_out(tmp_path: Path) -> None:
    """From an office that lets no UDP out, a friend drives by TURN over TCP, through our coturn."""
    toml = by_relay(f"turn:{TURN.address}:{PORT}?transport=tcp")
    async with staged(tmp_path, toml, ROBOT, OFFICE, TURN) as stage:
        way = {"type": "relay", "relay": "tcp", "to": f"{ROBOT.public}:{MEDIA}"}
        assert await stage.sees() == way
        await stage.drives()


async def test_relay_only_uses_nothing_else(tmp_path: Path) -> None:
    """The relay is used even where a direct connection is possible."""
    toml = by_relay(f"turn:{TURN.address}:{PORT}", "only = true")
    async with staged(tmp_path, toml, ROBOT, FRIEND, TURN) as stage:
        assert (await stage.sees())["type"] == "relay"
        await stage.drives()


async def test_without_a_forwarded_port_full_ice_helps(tmp_path: Path) -> None:
    """Both routers are opened from inside, by what a STUN server tells each end."""
    toml = BASE.replace(f"udp_port = {MEDIA}", 'mode = "full-ice"').replace(
        f'public_addresses = ["{ROBOT.public}"]', f'stun = ["stun:{TURN.address}:{PORT}"]'
    )
    toml = toml.replace("[server]", f'[server]\nnames = ["{ROBOT.public}"]')
    closed = replace(ROBOT, forwards=(("tcp", HTTP),))
    async with staged(tmp_path, toml, closed, FRIEND, TURN) as stage:
        assert (await stage.sees())["to"].startswith(f"{ROBOT.public}:")
        await stage.drives()
