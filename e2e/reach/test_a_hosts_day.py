"""A host's day: a distant friend drives, a troll comes again and again, and the records say so."""

from __future__ import annotations

import asyncio
import json
import tomllib
from contextlib import AsyncExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pytest
import tomlkit
from playwright.async_api import async_playwright

from e2e.harness import toml
from e2e.harness.commands import said_by
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.reach.internet import Host, Internet
from e2e.reach.stage import FRIEND, HTTP, ROBOT, URL, browser_at, obeys, serving
from wax.access.admission import BANNED, LOCKED

if TYPE_CHECKING:
    from playwright.async_api import Browser

LAPTOP: Final = Host("laptop", "192.168.1.3", public=ROBOT.public)
TROLL: Final = Host("troll", "192.168.0.2", public="198.51.100.66")
CAFE: Final = Host("cafe", "172.16.0.2", public="198.51.100.67")
HERE: Final = {
    "server": {"public_url": URL},
    "network": {"public_addresses": [ROBOT.public]},
    "video": {"source": "robot"},
    "robot": {"driver": "simulated"},
    "log": {"format": "text"},
}
"""What a host changes in `config/public-robot.toml`: the robot, and where they live."""
_FITS: Final = "document.documentElement.scrollWidth <= window.innerWidth"
_SHIPPED: Final = Path(__file__).parents[2] / "config" / "public-robot.toml"


async def opens(browser: Browser, link: str) -> Viewer:
    """Open a link in a new window, which shares no cookies with others."""
    return await Viewer.at(await browser.new_context(), link)


async def reads(viewer: Viewer, sentence: str) -> None:
    """Wait until the page is nothing but this sentence and a way back."""
    await viewer.page.get_by_role("heading", name=sentence).wait_for(timeout=15_000)


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_hosts_day(tmp_path: Path) -> None:
    """An invited friend elsewhere drives on, whatever the troll does whom the host removes."""
    settings = toml.merged(
        tomllib.loads(_SHIPPED.read_text(encoding="utf-8")),
        HERE,
        {"server": {"state_dir": str(tmp_path / "state")}},
    )
    async with Internet(ROBOT, LAPTOP, FRIEND, TROLL, CAFE) as net:
        await _day(net, tmp_path, tomlkit.dumps(settings))


async def _day(net: Internet, folder: Path, settings: str) -> None:
    async with AsyncExitStack() as day:
        playwright = await day.enter_async_context(async_playwright())
        robot = await day.enter_async_context(serving(net, folder, settings))
        laptop, elsewhere, trolls, cafe = await asyncio.gather(
            *(
                day.enter_async_context(browser_at(net, host.name, playwright))
                for host in (LAPTOP, FRIEND, TROLL, CAFE)
            )
        )

        links = (await said_by(folder, "host-link")).split()
        at_home = next(link for link in links if link.startswith(f"http://{ROBOT.address}:{HTTP}/"))
        host = await opens(laptop, at_home)
        await host.sees_picture()
        # Without HTTPS the browser's player plays the sound; the page says what HTTPS would bring.
        await host.open("Details")
        await host.page.get_by_text("over HTTPS this page could play").wait_for(state="attached")
        await host.page.get_by_role("button", name="Host", exact=True).click()
        await host.button("Make a link").click()
        assert await host.page.evaluate(_FITS)
        link = await host.page.get_by_role("textbox", name="Invitation link").input_value()
        assert link.startswith(f"{URL}/#invite=")

        friend = await opens(elsewhere, link)
        await friend.page.get_by_text("You are invited to drive.").wait_for()
        await friend.sees_picture()
        assert friend.page.url == f"{URL}/"
        await friend.call_oneself("Ada")
        await friend.takes_the_wheel()
        await obeys(robot, friend)

        troll = await opens(trolls, URL)
        await troll.sees_picture()
        await troll.call_oneself("Troll")
        line = host.page.locator(".person", has_text="Troll")
        await line.wait_for()
        await troll.button("Stop").click()
        await friend.page.get_by_text("Stopped by Troll").first.wait_for()
        await line.get_by_role("button", name="Remove…").click()
        await line.get_by_role("button", name="Remove and keep out for a day").click()
        await reads(troll, str(BANNED))
        await friend.release_stop()
        await obeys(robot, friend)

        # A new identity: refused from the same address, admitted from another.
        await reads(await opens(trolls, URL), str(BANNED))
        again = await opens(cafe, URL)
        await again.sees_picture()
        await host.button("Only invited people").click()
        await reads(again, str(LOCKED))
        await obeys(robot, friend)
        await host.sees_picture()

        assert not [error for one in (host, friend, troll, again) for error in one.errors]

        async def night() -> dict[str, list[dict[str, Any]]] | None:
            found: dict[str, list[dict[str, Any]]] = json.loads(
                await said_by(folder, "records", "--json")
            )
            return found if len(found["acts"]) == 3 else None

        tables = await eventually(night, "all acts are recorded", within_s=5, every_s=0.5)
        assert tables is not None
        assert [(one["name"], one["ended"]) for one in tables["turns"]] == [("Ada", None)]
        [stop] = [one for one in tables["stops"] if one["reason"] == "pressed"]
        assert (stop["name"], stop["released_by"]) == ("Troll", "Ada")
        _, remove, lock = tables["acts"]
        assert [one["act"] for one in tables["acts"]] == ["invite", "remove", "lock"]
        assert "Troll" in remove["about"]
        assert json.loads(remove["detail"]) == {"ban": True}
        assert json.loads(lock["detail"]) == {"locked": True}
        assert link.partition("=")[2] not in json.dumps(tables)
