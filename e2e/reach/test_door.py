"""People elsewhere reach a robot that dials out to a door, even when the door dies."""

from __future__ import annotations

import asyncio
import json
import os
import time
from contextlib import asynccontextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import pytest
import tomlkit
from playwright.async_api import async_playwright

from e2e.harness.board import Board
from e2e.harness.chromium import chromium_at
from e2e.harness.commands import said_by
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.link import namespace
from e2e.reach.door import DOOR, NAME, OTHER_NAME, Door, aliases, door
from e2e.reach.internet import Host, Internet
from e2e.reach.stage import FRIEND, Stage, serving, telling_logs
from e2e.stop.record import Record
from wax.__main__ import main

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from e2e.delay.systems.wax import Wax

CARRIED: Final = Host("robot", "192.168.1.2", public="100.64.0.2", carrier="203.0.113.1")
OFFICE: Final = Host("friend", "10.1.1.2", public="203.0.113.3", udp=False)
IPV6: Final = "2001:db8:1::2"
URL: Final = f"https://{NAME}"
SHUT: Final = """table inet shut {
    chain in {
        type filter hook input priority filter
        tcp dport 22 drop
    }
}
"""
BASE: Final = """
[server]
state_dir = "{state}"
[audio]
source = "none"
"""
CARD: Final = {"video": {"source": "testcard"}}

pytestmark = pytest.mark.timeout(120)

HAS_THE_SERVERS_WORDS: Final = """
    performance.getEntriesByType("resource").some(one => one.name.includes("/sentences-"))
"""
"""Loaded after picture and sound, at most 4 s after connecting; without the door they never
come."""


class Dialling:
    """A robot that dials out, and its door."""

    def __init__(self, net: Internet, robot: Wax, door: Door, toml: Path) -> None:
        self.net = net
        self.robot = robot
        self.door = door
        self.toml = toml

    async def tunnel(self) -> dict[str, Any]:
        told: dict[str, Any] = (await self.robot.status())["door"]
        return told

    async def leads(self, within_s: float, *, here: bool = True) -> None:
        """Wait until the door leads to the robot; with `here` False, until it no longer does."""

        async def is_so() -> bool:
            return (await self.tunnel())["is_open"] is here

        await eventually(is_so, "the door leads to the robot", within_s=within_s)

    async def tells(self, words: str) -> None:
        """Wait until the host reads these words about the door."""

        async def is_so() -> bool:
            return words in ((await self.tunnel())["problem"] or "")

        await eventually(is_so, f"the host reads {words!r}", within_s=15)

    async def doctor(self, host: str = "robot", *words: str) -> dict[str, str]:
        """Return the level of each of the doctor's verdicts."""
        words = words or ("--config", str(self.toml))
        process = await self.net[host].spawn_python(
            ["-m", "wax", "doctor", "--json", *words],
            stdout=asyncio.subprocess.PIPE,
            env={**os.environ, "SSL_CERT_FILE": self.door.root},
        )
        said, _ = await process.communicate()
        return {one["check"]: one["level"] for one in json.loads(said)}


def configured(folder: Path, line: str, name: str = "robot") -> Path:
    """Return what `wax init` makes of a robot that is there and of a door's line."""
    path = folder / f"{name}.toml"
    path.write_text(BASE.format(state=folder / "state"), encoding="utf-8")
    assert main(["init", "--door", line, str(path)]) == 0
    return path


@asynccontextmanager
async def dialling(
    folder: Path,
    *hosts: Host,
    names: tuple[str, ...] = (NAME,),
    more: str = "",
) -> AsyncIterator[Dialling]:
    """Set up a door for robots of these names, and serve the first, configured with `more`."""
    async with Internet(*hosts, DOOR) as net:
        with telling_logs(folder):
            there = await door(net, folder, *names)
            path = configured(folder, there.line())
        toml, variables = path.read_text(encoding="utf-8"), {"SSL_CERT_FILE": there.root}
        async with serving(net, folder, toml + more, variables=variables) as robot:
            yield Dialling(net, robot, there, path)


@asynccontextmanager
async def visited(dials: Dialling) -> AsyncIterator[Stage]:
    """Open its page in the friend's browser, by the door's name."""
    await dials.leads(10)
    async with (
        async_playwright() as playwright,
        chromium_at(dials.net["friend"], playwright, aliases(NAME)) as browser,
    ):
        context = await browser.new_context(ignore_https_errors=True)
        yield Stage(dials.net, dials.robot, await Viewer.at(context, URL))


@asynccontextmanager
async def overhearing(net: Internet, folder: Path) -> AsyncIterator[Callable[[], float]]:
    """Yield a function that returns when the newest command reached the robot by the relay."""
    path = folder / "commands"
    with path.open("wb") as said:
        words = ["-m", "e2e.reach.overheard", DOOR.address]
        process = await net["robot"].spawn_python(words, stdout=said)
    try:
        yield lambda: float(path.read_text(encoding="ascii").split()[-1])
    finally:
        process.kill()


async def visits(folder: Path) -> list[dict[str, Any]]:
    kept: list[dict[str, Any]] = json.loads(await said_by(folder, "records", "sessions", "--json"))
    return kept


@pytest.mark.full
async def test_a_robot_behind_two_nats_is_driven_through_its_door(tmp_path: Path) -> None:
    """HTTPS has a real name; picture and commands bypass the door, and continue without it."""
    async with dialling(tmp_path, CARRIED, FRIEND) as dials, visited(dials) as stage:
        way = await stage.sees()
        assert way["type"] != "relay"
        assert way["to"].startswith(f"{CARRIED.carrier}:")
        assert await stage.viewer.page.evaluate("isSecureContext")
        assert (await dials.doctor("friend", "--reach", URL))["viewer"] == "ok"
        has_words = partial(stage.viewer.page.evaluate, HAS_THE_SERVERS_WORDS)
        await eventually(has_words, "the page has the server's words")
        await dials.door.kill()
        await stage.viewer.page.get_by_text("Nobody new can join").wait_for()
        await stage.drives()
        await stage.viewer.button("Stop").click()
        await stage.viewer.release_stop()
        kept = await eventually(partial(visits, tmp_path), "the visits are kept")
        assert {one["address"] for one in kept} == {"203.0.113.0/24"}  # not the tunnel's


@pytest.mark.full
@pytest.mark.parametrize(
    ("robot", "friend", "to"),
    [
        (CARRIED, replace(FRIEND, address="192.168.1.3", public=CARRIED.public), CARRIED.address),
        (replace(CARRIED, ipv6=IPV6), replace(FRIEND, ipv6="2001:db8:7::2"), IPV6),
        (CARRIED, Host("friend", "2001:db8:7::2"), DOOR.address),
    ],
    ids=["the robot's home", "IPv4 and IPv6", "IPv6 alone"],
)
async def test_each_finds_the_shortest_way(
    tmp_path: Path, robot: Host, friend: Host, to: str
) -> None:
    """Everybody uses the public name; at home, and by IPv6, nothing is translated or relayed."""
    async with dialling(tmp_path, robot, friend) as dials, visited(dials) as stage:
        way = await stage.sees()
        assert way["to"].startswith(f"{to}:"), way
        assert (way["type"] == "relay") is (to == DOOR.address)
        await stage.drives()


@pytest.mark.full
async def test_where_there_is_no_direct_way_the_relay_carries(tmp_path: Path) -> None:
    """An office without UDP reaches a robot behind a symmetric NAT.

    When the relay dies, the board is told to stop within 200 ms of the last command. It stands
    until the page, which reconnects within its turn, sends a new press.
    """
    hosts = replace(CARRIED, symmetric=True), OFFICE
    async with (
        Board(tmp_path) as board,
        dialling(tmp_path, *hosts, more=tomlkit.dumps(CARD | {"robot": board.robot})) as dials,
        overhearing(dials.net, tmp_path) as commands_s,
        visited(dials) as stage,
    ):
        way = await stage.sees()
        assert (way["type"], way["relay"]) == ("relay", "tcp")
        assert way["to"].startswith(f"{DOOR.address}:")
        await stage.viewer.takes_the_wheel()
        number = (await dials.robot.status())["turn"]["number"]
        keys, record = stage.viewer.page.keyboard, Record(board.log_path)

        async def drives() -> bool:
            await keys.down("ArrowLeft")
            await asyncio.sleep(0.6)
            record.read()
            if not record.moved_at(time.monotonic()):
                await keys.up("ArrowLeft")
                return False
            return True

        await eventually(drives, "the robot moves")
        await dials.door.kill()
        await stage.viewer.page.get_by_text("Reconnecting").first.wait_for()
        last_s = commands_s()
        await dials.door.start()
        await stage.sees()
        await stage.viewer.drives()
        assert (await dials.robot.status())["turn"]["number"] == number
        record.read()
        assert record.moved_at(last_s), "it did not move when the relay died"
        stopping = record.stopping(last_s, time.monotonic())
        assert stopping.told_ms is not None
        print(f"last command by the relay → told to stand: {stopping.told_ms:.0f} ms")
        assert stopping.told_ms <= 200
        assert not stopping.moved_again_ms
        await keys.up("ArrowLeft")
        await eventually(drives, "the robot moves by a new press")
        await keys.up("ArrowLeft")


@pytest.mark.full
async def test_a_door_that_dies_or_falls_silent_is_missed_and_found_again(tmp_path: Path) -> None:
    """A lost door is noticed within 10 s, its return within 5 s, and `wax doctor` agrees."""
    async with dialling(tmp_path, CARRIED) as dials:
        await dials.leads(10)
        assert {level for check, level in (await dials.doctor()).items() if "door" in check} == {
            "ok"
        }
        await dials.door.kill()
        await dials.leads(2, here=False)
        await dials.tells("does not answer at TCP 22 or 443")
        assert (await dials.doctor())["door's tunnel"] == "bad"
        await dials.door.start()
        await dials.leads(5)
        await dials.door.unplug()
        await dials.leads(10, here=False)
        await dials.door.plug()
        await dials.leads(5)


@pytest.mark.full
async def test_where_22_is_closed_the_tunnel_goes_by_443(tmp_path: Path) -> None:
    """The tunnel goes through Caddy, as from a school's network that lets nothing else out."""
    async with dialling(tmp_path, CARRIED) as dials:
        await dials.leads(10)
        rules = tmp_path / "shut.nft"
        rules.write_text(SHUT, encoding="ascii")
        nft = [namespace.tool("nft", "nftables"), "-f", str(rules)]
        shut = await dials.net["door"].spawn(nft)
        assert await shut.wait() == 0
        await dials.leads(10, here=False)
        await dials.leads(20)
        assert (await dials.tunnel())["way"] == "https"
        assert (await dials.doctor())["door's tunnel"] == "warning"


@pytest.mark.full
async def test_no_robot_takes_anothers_place(tmp_path: Path) -> None:
    """A robot gets it neither with its own key and another's port nor with another's whole line."""
    async with dialling(tmp_path, CARRIED, names=(NAME, OTHER_NAME)) as dials:
        await dials.leads(10)
        path = configured(tmp_path, dials.door.line(OTHER_NAME), "other")
        own, port = path.read_text(encoding="utf-8"), "port = 20001"
        for number, text in enumerate(
            (own.replace("port = 20002", port), dials.toml.read_text(encoding="utf-8"))
        ):
            assert port in text
            second = text.replace("[server]", f"[server]\nport = {9000 + number}")
            path.write_text(second, encoding="utf-8")
            other = Dialling(dials.net, dials.robot, dials.door, path)
            assert (await other.doctor())["door's tunnel"] == "bad"
        assert (await dials.tunnel())["is_open"]


@pytest.mark.full
async def test_another_host_key_is_never_trusted(tmp_path: Path) -> None:
    """If the name leads elsewhere, or the door was set up anew, the host reads what to do."""
    async with dialling(tmp_path, CARRIED) as dials:
        await dials.leads(10)
        text = dials.toml.read_text(encoding="utf-8")
        start = text.index("AAAAC3NzaC1lZDI1NTE5AAAAI") + 30
        dials.toml.write_text(f"{text[:start]}{'A' * 8}{text[start + 8 :]}", encoding="utf-8")
        assert (await dials.doctor())["door's tunnel"] == "bad"
