"""Strangers in the room: what the host does about them, as everybody's page shows it.

A trusted proxy reports where each person comes from, since this machine's own address is never
banned.
"""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING, Any, Final

import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.commands import become_host
from e2e.harness.robot import moves, stands_still
from e2e.harness.wait import eventually
from e2e.measure.ear import SILENT
from wax.access.admission import BANNED, LOCKED
from wax.client import Operator
from wax.errors import SignallingError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server

    Come = Callable[..., Awaitable[Operator]]

pytestmark = pytest.mark.timeout(90)

HERS: Final = "192.0.2.7"
TROLLS: Final = "192.0.2.66"
"""Addresses for documentation (RFC 5737)."""

SERVER_SETTINGS: Final = toml.card_with(
    server='trusted_proxies = ["127.0.0.1"]', log='level = "debug"'
)


@pytest_asyncio.fixture(loop_scope="session")
async def come(server: Server) -> AsyncIterator[Come]:
    """Let somebody join; they leave at the end of the test."""
    async with AsyncExitStack() as leaving:

        async def one(address: str = HERS, **options: Any) -> Operator:
            client = Operator(server.url, headers=_from(address), **options)
            return await leaving.enter_async_context(client)

        yield one


@pytest.mark.full
async def test_blanked_there_is_nothing_to_see(server: Server, open_viewer: OpenViewer) -> None:
    """While the host wants privacy the picture is black, the sound silent, and the robot stands."""
    async with (
        Operator(server.url, cookies=await server.host_cookies()) as host,
        Operator(server.url, sees=True) as operator,
    ):
        viewer = await open_viewer(server)
        await viewer.listen()
        await operator.join()

        async def turns() -> bool:
            operator.let_go()
            await asyncio.sleep(0.1)
            operator.steer(0.0, 1.0)
            return await moves(server, within_s=0.5)

        async def sounds() -> bool:
            viewer.forget()
            await asyncio.sleep(0.4)
            return any(one.rms > SILENT for one in viewer.heard())

        async def is_silent() -> bool:
            return not await sounds()

        await eventually(turns, "the robot turns")
        await eventually(sounds, "the robot is heard")
        assert not await viewer.is_dark()
        host.send(type="blank", blanked=True)
        assert await stands_still(server)
        await eventually(viewer.is_dark, "the picture is black")
        await eventually(is_silent, "the sound is silent")
        assert not await turns()
        host.send(type="blank", blanked=False)
        await eventually(turns, "the robot turns again")
        await eventually(sounds, "the sound is back")


async def test_a_host_blanks_the_picture_bans_a_troll_and_closes(
    server: Server, come: Come, open_viewer: OpenViewer
) -> None:
    """Everybody reads about each act, and only a banned person cannot return."""
    proxied = {"extra_http_headers": _from(TROLLS)}
    host, troll = await open_viewer(server), await open_viewer(server, **proxied)
    assert await host.page.get_by_role("button", name="Host", exact=True).count() == 0
    await become_host(host, server)
    assert host.page.url == f"{server.url}/"
    await troll.call_oneself("Troll")
    await host.page.get_by_role("button", name="Host", exact=True).click()

    blank = host.switch("Picture and sound off for everybody")
    await blank.click()
    await troll.page.get_by_text("The host has switched picture and sound off").wait_for()
    await blank.click()
    await troll.sees_picture()

    line = host.page.locator(".person", has_text="Troll")
    await line.get_by_role("button", name="Remove…").click()
    await line.get_by_role("button", name="Remove and keep out for a day").click()
    await troll.page.get_by_text(str(BANNED)).first.wait_for()
    await line.wait_for(state="hidden")
    await troll.button("Try again").click()
    await troll.page.get_by_text(str(BANNED)).first.wait_for()
    assert str(BANNED) in await refusal(come(TROLLS))

    other = await come("192.0.2.67")
    await host.button("Only invited people").click()
    assert await other.until(lambda: other.newest("ended").get("text") == LOCKED.wire(), 20)
    await host.button("Let strangers in again").click()

    last = await open_viewer(server)
    await host.button("Close for today…").click()
    await host.button("Close").click()
    closed = last.page.get_by_role("heading", name="The robot is closed.")
    await closed.wait_for()
    await last.button("Try again").click()
    await closed.wait_for()


def _from(address: str) -> dict[str, str]:
    """Return a proxy's headers about the person for whom it asks."""
    return {"X-Forwarded-For": address}


async def refusal(request: Awaitable[Any]) -> str:
    with pytest.raises(SignallingError) as refused:
        await request
    return str(refused.value)
