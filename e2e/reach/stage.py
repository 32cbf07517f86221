"""Shared by the tests of the small internet: the robot's host, a server there, and browsers."""

from __future__ import annotations

from contextlib import asynccontextmanager, contextmanager
from typing import TYPE_CHECKING, Final

from e2e.delay.systems import wax
from e2e.delay.systems.served import PORT
from e2e.harness.chromium import chromium_at
from e2e.harness.robot import key_moves
from e2e.harness.wait import eventually
from e2e.reach.internet import Host

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Mapping
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from playwright.async_api import Browser, Playwright

    from e2e.delay.systems.wax import Wax
    from e2e.harness.viewer import Viewer
    from e2e.reach.internet import Internet

HTTP: Final = PORT
MEDIA: Final = 8081
ROBOT: Final = Host(
    "robot", "192.168.1.2", public="203.0.113.1", forwards=(("tcp", HTTP), ("udp", MEDIA))
)
FRIEND: Final = Host("friend", "192.168.7.2", public="203.0.113.2")
TURN: Final = Host("turn", "203.0.113.9")
URL: Final = f"http://{ROBOT.public}:{HTTP}"


async def obeys(robot: Wax, viewer: Viewer) -> None:
    """Hold a key as this viewer, and check that the robot moves."""
    assert await key_moves(robot, viewer.page, "ArrowUp", 10.0), "the robot stands"
    await viewer.page.keyboard.up("ArrowUp")


@contextmanager
def telling_logs(folder: Path) -> Iterator[None]:
    """If the test fails, print the end of each log for its report."""
    try:
        yield
    except BaseException:
        for path in folder.glob("*.log"):
            print(f"{path.name}:\n{path.read_text(encoding='utf-8', errors='replace')[-4000:]}")
        raise


@asynccontextmanager
async def serving(
    net: Internet, folder: Path, toml: str, variables: Mapping[str, str] | None = None
) -> AsyncIterator[Wax]:
    """Serve at the robot's host; the state and the log are in ``state`` of `folder`."""
    place = ("--host", "0.0.0.0", "--port", str(HTTP))
    with telling_logs(folder):
        async with wax.serving(net["robot"], folder, toml, *place, variables=variables) as served:
            await served.become_host(folder / "state")
            yield served


def browser_at(
    net: Internet, name: str, playwright: Playwright
) -> AbstractAsyncContextManager[Browser]:
    known = [str(ROBOT.public), ROBOT.address, TURN.address]
    return chromium_at(net[name], playwright, known)


class Stage:
    """A robot that serves, and the browser of a friend elsewhere."""

    def __init__(self, net: Internet, robot: Wax, viewer: Viewer) -> None:
        self.net = net
        self.viewer = viewer
        self._robot = robot

    async def drives(self) -> None:
        if not await self.viewer.page.get_by_text("You are driving").first.is_visible():
            await self.viewer.takes_the_wheel()
        await obeys(self._robot, self.viewer)

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
