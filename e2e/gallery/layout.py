"""Rules for the layout in every state, window and theme."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from playwright.async_api import Page

_SCRIPT: Final = Path(__file__).with_name("layout.js").read_text(encoding="utf-8")
_EDGES: Final = Path(__file__).with_name("edges.js").read_text(encoding="utf-8")
_MOVES: Final = """() => document.getAnimations()
    .filter((one) => one.playState === "running")
    .filter((one) => one.effect.getComputedTiming().endTime > 200)
    .map((one) => `<${one.effect.target.localName}.${one.effect.target.className}> moves on`)"""
"""Returns every animation that is neither over at once nor paused."""


async def faults(page: Page, *, has_stop: bool) -> list[str]:
    """Return what is wrong: the page scrolls sideways, Stop is hidden, a target is small."""
    stop = page.get_by_role("button", name="Stop", exact=True)
    count = await stop.count()
    if has_stop and count != 1:
        return [f"there are {count} Stop buttons", *await page.evaluate(f"({_SCRIPT})(null)")]
    button = await stop.element_handle() if has_stop else None
    found: list[str] = await page.evaluate(_SCRIPT, button)
    return found


async def vanished(page: Page) -> list[str]:
    """Return what has no edge in forced colours: a button, or the chosen one of a few options."""
    await page.emulate_media(forced_colors="active")
    found: list[str] = await page.evaluate(_EDGES)
    await page.emulate_media(forced_colors="none")
    return found


async def moving(page: Page) -> list[str]:
    """Return what still moves for somebody who asks for less motion."""
    await page.emulate_media(reduced_motion="reduce")
    found: list[str] = await page.evaluate(_MOVES)
    await page.emulate_media(reduced_motion="no-preference")
    return found
