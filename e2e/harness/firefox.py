"""The page in a stock Firefox."""

from __future__ import annotations

from contextlib import asynccontextmanager
from types import MappingProxyType
from typing import TYPE_CHECKING

from e2e.harness.bidi import firefox
from e2e.harness.scripts import press
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping
    from pathlib import Path

    from e2e.harness.bidi import Firefox
    from e2e.harness.server import Server
    from e2e.measure.ear import Ear


@asynccontextmanager
async def opened(
    server: Server,
    folder: Path,
    ear: Ear | None = None,
    preferences: Mapping[str, int] = MappingProxyType({}),
) -> AsyncIterator[Firefox]:
    """Have the page open in a Firefox without a past, whose picture plays."""
    async with firefox(folder, ear, preferences) as window:
        await window.goto(server.url)
        await eventually(
            lambda: window.evaluate("waxProbe.playing()"), "the picture plays", within_s=30
        )
        yield window


async def presses(window: Firefox, name: str) -> None:
    """Press the button with this text or label, once it can be."""
    await eventually(lambda: window.evaluate(press(name)), f"“{name}” can be pressed")
