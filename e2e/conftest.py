"""Browsers and servers for the tests; if a test fails, the logs of both are part of its report."""

from __future__ import annotations

import os
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio
from playwright.async_api import async_playwright
from tests.examples import load_profiles

from e2e.harness import toml
from e2e.harness.board import Board
from e2e.harness.chromium import launch_chromium
from e2e.harness.server import Server
from e2e.harness.viewer import Viewer
from e2e.measure.ear import open_ear
from e2e.measure.errors import NotRunError
from wax.machine.priority import NICENESS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Generator
    from contextlib import AbstractAsyncContextManager

    from playwright.async_api import Browser

    from e2e.measure.ear import Ear

    OpenViewer = Callable[..., Awaitable[Viewer]]
    Serve = Callable[..., AbstractAsyncContextManager[Server]]

load_profiles()

MEASURES = ("delay", "instrument", "link", "load", "peers", "reach")
"""Folders of tests for measurements and other systems, which only `make test-all` runs."""

SERVERS = pytest.StashKey[list[Server]]()
VIEWERS = pytest.StashKey[list[Viewer]]()


def pytest_configure(config: pytest.Config) -> None:
    config.stash[SERVERS] = []
    config.stash[VIEWERS] = []


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests by their folders; use one event loop, because the browser lives on it."""
    here = Path(__file__).parent
    for item in items:
        if not item.path.is_relative_to(here):
            continue
        part = item.path.relative_to(here).parts[0]
        if part in MEASURES:
            item.add_marker(pytest.mark.full)
        if pytest_asyncio.is_async_test(item):
            item.add_marker(pytest.mark.asyncio(loop_scope="session"), append=False)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Generator[None]:
    """Skip a test that needs what this machine lacks; fail it where ``CI`` is set."""
    try:
        yield
    except NotRunError as error:
        if os.environ.get("CI", "").lower() in {"1", "true", "yes"}:
            pytest.fail(f"nothing is skipped in CI: {error}", pytrace=False)
        pytest.skip(str(error))


pytest_runtest_call = pytest_runtest_setup


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, Any, Any]:
    report = yield
    if report.failed:
        for server in item.config.stash[SERVERS]:
            report.sections.append((f"server {server.url}", server.account()))
        for viewer in item.config.stash[VIEWERS]:
            lines = "\n".join([*viewer.console[-40:], *viewer.errors])
            report.sections.append((f"page {viewer.url}", lines))
    return report


async def sound_device() -> AsyncIterator[Ear | None]:
    """Run a sound device for a browser; None without PulseAudio."""
    async with AsyncExitStack() as leaving:
        made = None
        with suppress(NotRunError):
            made = await leaving.enter_async_context(open_ear())
        yield made


ear = pytest_asyncio.fixture(sound_device, scope="session", loop_scope="session")


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def chromium(ear: Ear | None) -> AsyncIterator[Browser]:
    async with (
        async_playwright() as playwright,
        await launch_chromium(playwright, ear=ear) as browser,
    ):
        yield browser


@pytest.fixture(scope="session")
def serve(pytestconfig: pytest.Config) -> Serve:
    """Run a server around a block: it serves inside and stops cleanly afterwards."""

    @asynccontextmanager
    async def serving(folder: Path, toml: str) -> AsyncIterator[Server]:
        server = Server(folder, toml)
        server.niceness = NICENESS  # before browsers, which really are on other machines
        pytestconfig.stash[SERVERS].append(server)
        try:
            async with server:
                try:
                    yield server
                except Exception as error:
                    error.add_note(server.account())  # it is gone once the failure is reported
                    raise
        finally:
            pytestconfig.stash[SERVERS].remove(server)

    return serving


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def card_server(
    serve: Serve, tmp_path_factory: pytest.TempPathFactory
) -> AsyncIterator[Server]:
    async with serve(tmp_path_factory.mktemp("card"), toml.CARD) as running:
        yield running


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def own_server(
    request: pytest.FixtureRequest, serve: Serve, tmp_path_factory: pytest.TempPathFactory
) -> AsyncIterator[Server]:
    settings = request.module.SERVER_SETTINGS
    async with serve(tmp_path_factory.mktemp("server"), settings) as running:
        yield running


@pytest.fixture(scope="module")
def server(request: pytest.FixtureRequest) -> Any:
    """Serve a module's `SERVER_SETTINGS`, or, for all tests that change nothing, the test card."""
    has_own = hasattr(request.module, "SERVER_SETTINGS")
    return request.getfixturevalue("own_server" if has_own else "card_server")


@pytest_asyncio.fixture(loop_scope="session")
async def driver(server: Server, open_viewer: OpenViewer) -> Viewer:
    """Open a page whose viewer drives."""
    return await open_viewer(server, drives=True)


@pytest_asyncio.fixture(loop_scope="session")
async def board(tmp_path: Path) -> AsyncIterator[Board]:
    """Plug the real firmware's core into a pseudo-terminal."""
    async with Board(tmp_path) as made:
        yield made


@pytest_asyncio.fixture(loop_scope="session")
async def open_viewer(
    chromium: Browser, ear: Ear | None, pytestconfig: pytest.Config
) -> AsyncIterator[OpenViewer]:
    """Open a browser of one viewer's own on a server; it closes at the end of the test."""
    viewers = pytestconfig.stash[VIEWERS]
    async with AsyncExitStack() as leaving:

        async def open_one(
            server: Server,
            *,
            is_host: bool = False,
            drives: bool = False,
            first: str = "",  # runs before any other script
            **options: Any,
        ) -> Viewer:
            context = await chromium.new_context(**options)
            leaving.push_async_callback(context.close)
            await context.add_init_script(first)
            if is_host:
                await server.make_host(context)
            viewer = await Viewer.prepare(context, server.url, ear)
            viewers.append(viewer)
            await viewer.page.goto(server.url)
            await viewer.sees_picture()
            leaving.push_async_callback(viewer.leaves)  # the next test need not wait for their turn
            if drives:
                await viewer.takes_the_wheel()
            return viewer

        yield open_one
    errors = [error for viewer in viewers for error in viewer.errors]
    viewers.clear()
    assert not errors, f"uncaught errors in a page: {errors}"
