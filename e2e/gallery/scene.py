"""A robot with a server, the page that is photographed, and the other people in the room."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import tomlkit
from playwright.async_api import Error

from e2e.gallery.views import COMPUTER
from e2e.harness import toml
from e2e.harness.board import Board
from e2e.harness.server import Server
from e2e.harness.viewer import Viewer
from e2e.stop.camera import SOURCE, Control
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser, Route

    from e2e.gallery.views import Device

_FLAT: Final[dict[str, Any]] = {
    "video": {"source": "robot", "width": "auto", "height": "auto"},
    "audio": {"source": "robot"},
    # A viewer whose page is closed is forgotten soon.
    "turns": {"grace_s": 0.5},
}
"""The simulated robot in its flat: what `make run` shows."""


class Scene:
    """The means of the stories in `e2e.gallery.states`; all of them end with the scene.

    A story that needs more than `_FLAT` calls `serves` before anybody joins, and each calls
    `prepares`, directly or not.
    """

    def __init__(self, browser: Browser, device: Device, folder: Path, stack: AsyncExitStack):
        self.device = device
        self.folder = folder
        self._browser = browser
        self._stack = stack
        self._server: Server | None = None
        self._viewer: Viewer | None = None

    @property
    def is_touched(self) -> bool:
        return self.device is not COMPUTER

    @property
    def server(self) -> Server:
        assert self._server is not None, "nobody has come yet"
        return self._server

    @property
    def viewer(self) -> Viewer:
        """The page that is photographed."""
        assert self._viewer is not None, "the story has not called `prepares`"
        return self._viewer

    # --- the robot and the server -------------------------------------------------------------

    async def serves(self, *, environment: dict[str, str] | None = None, **tables: Any) -> None:
        """Start the server; `tables` are of its configuration."""
        server = self._server = Server(self.folder, tomlkit.dumps(toml.merged(_FLAT, tables)))
        server.environment |= environment or {}
        self._stack.push_async_callback(server.kill)
        await server.start()

    async def board(self) -> Board:
        """Plug the real firmware in, for ``robot=board.robot``."""
        return await self._stack.enter_async_context(Board(self.folder))

    async def serves_a_camera(self) -> Control:
        """Start the server with a camera that freezes on request."""
        camera = self._stack.enter_context(Control())
        media = {"video": {"source": SOURCE}, "audio": toml.MEDIA["audio"]}
        await self.serves(environment=camera.environment, **media)
        return camera

    async def loses(self, requests: str) -> None:
        """Answer none of these requests of the page, as if the network had lost them."""
        is_over = asyncio.Event()

        async def lost(route: Route) -> None:
            await is_over.wait()
            with suppress(Error):  # its page is closed by then
                await route.abort()

        async def end() -> None:
            is_over.set()
            await self.viewer.page.unroute_all(behavior="wait")

        await self.viewer.page.route(requests, lost)
        self._stack.push_async_callback(end)

    # --- the people ---------------------------------------------------------------------------

    async def prepares(self, *, is_host: bool = False) -> Viewer:
        """Prepare the browser of the person whose page is photographed, with no page open yet."""
        if self._server is None:
            await self.serves()
        context = await self._browser.new_context(**self.device.context)
        self._stack.push_async_callback(context.close)
        if is_host:
            await self.server.make_host(context)
        self._viewer = await Viewer.prepare(context, self.server.url)
        return self._viewer

    async def opens(
        self, path: str = "/", *, is_host: bool = False, is_new: bool = False
    ) -> Viewer:
        """Open the page and wait for its picture; unless `is_new`, the first card is closed."""
        viewer = await self.prepares(is_host=is_host)
        await viewer.page.goto(self.server.url + path)
        await viewer.sees_picture()
        if not is_new:
            await viewer.puts_the_first_card_away()
        return viewer

    async def drives(self, **how: Any) -> Viewer:
        viewer = await self.opens(**how)
        await viewer.takes_the_wheel()
        return viewer

    async def comes(self, name: str, *, is_host: bool = False) -> Operator:
        """Let somebody else join, without a browser."""
        if self._server is None:
            await self.serves()
        cookies = await self.server.host_cookies() if is_host else None
        client = Operator(self.server.url, name=name, cookies=cookies)
        return await self._stack.enter_async_context(client)

    async def somebody_drives(self) -> Operator:
        operator = await self.comes("Ada")
        await operator.join()
        return operator

    async def somebody_waits(self, name: str = "Bob") -> Operator:
        waiting = await self.comes(name)
        waiting.send(type="join")
        has_place = await waiting.until(lambda: _waits(waiting), 20)
        assert has_place, f"{name} gets no place in the queue"
        return waiting


def _waits(client: Operator) -> bool:
    viewers = client.newest("room").get("viewers", [])
    return any(one["id"] == client.viewer and one["role"] == "queued" for one in viewers)


@asynccontextmanager
async def scene(browser: Browser, device: Device) -> AsyncIterator[Scene]:
    async with AsyncExitStack() as stack:
        folder = stack.enter_context(TemporaryDirectory(prefix="wax-gallery-"))
        yield Scene(browser, device, Path(folder), stack)
