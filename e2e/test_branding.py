"""The page is the host's own: as a browser shows it, and as others show a link to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest
import pytest_asyncio
import tomlkit

from wax.web import colours

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

ACCENT = "#ffd200"
"""A yellow that nobody could read on white."""
HOSTILE = '"><script>window.hurt = 1</script>'
WORSE = "\"><img src=x onerror='window.hurt = 2'>"
SIZE = (120, 63)


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    """Serve a robot that can be driven, of a host who writes what could hurt."""
    folder = tmp_path_factory.mktemp("own")
    picture = folder / "robot.png"
    cv2.imwrite(str(picture), np.full((SIZE[1], SIZE[0], 3), 90, np.uint8))
    settings: dict[str, Any] = {
        "page": {
            "name": HOSTILE,
            "sentence": WORSE,
            "rules": [HOSTILE],
            "links": [{"text": HOSTILE, "url": "https://example.org/?q='\"><script>"}],
            "picture": str(picture),
            "accent": ACCENT,
        },
        "turns": {"grace_s": 0.5},
    }
    async with serve(folder, tomlkit.dumps(settings)) as running:
        yield running


async def said_by(viewer: Viewer, name: str) -> str | None:
    """Return what the page's head says under a name, as the browser reads it."""
    found = viewer.page.locator(f'meta[property="{name}"], meta[name="{name}"]')
    return await found.get_attribute("content")


@pytest.mark.full
async def test_the_page_is_the_hosts_and_what_they_write_cannot_hurt(
    server: Server, open_viewer: OpenViewer
) -> None:
    """A link to it shows whose it is, their colour is legible, and markup is read as text."""
    viewer = await open_viewer(server)
    assert await viewer.page.title() == HOSTILE
    assert await said_by(viewer, "og:title") == HOSTILE
    for name in ("description", "og:description"):
        assert await said_by(viewer, name) == WORSE
    assert await said_by(viewer, "og:url") == f"{server.url}/"
    address = await said_by(viewer, "og:image")
    assert address is not None
    picture = await viewer.page.request.get(address)
    assert picture.headers["content-type"] == "image/png"
    assert "immutable" in picture.headers["cache-control"]
    shown = cv2.imdecode(np.frombuffer(await picture.body(), np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    assert shown.shape[1::-1] == SIZE

    for theme, shades in (("light", colours.light(ACCENT)), ("dark", colours.dark(ACCENT))):
        await viewer.page.emulate_media(color_scheme=theme)  # type: ignore[arg-type]  # one of both
        accent = await viewer.page.evaluate(
            "() => getComputedStyle(document.documentElement).getPropertyValue('--accent')"
        )
        assert accent.strip() == shades.accent

    await viewer.page.get_by_role("heading", name=HOSTILE, exact=True).first.wait_for()
    assert await viewer.page.evaluate("() => window.hurt") is None
    assert await viewer.page.locator("script:not([src]), img[src=x]").count() == 0
    assert not [line for line in viewer.console if "Content Security Policy" in line]
