"""What axe-core finds on the page, as sentences."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.errors import NotRunError
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from playwright.async_api import Page

_SOURCE: Final = ROOT / "web/node_modules/axe-core/axe.min.js"
_TAGS: Final = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa")
_RUN: Final = Path(__file__).with_name("axe.js").read_text(encoding="utf-8")


@cache
def _source() -> str:
    if not _SOURCE.exists():
        raise NotRunError("axe-core is not installed: type make test, or npm ci in web/")
    return _SOURCE.read_text(encoding="utf-8")


async def findings(page: Page) -> list[str]:
    """Return a sentence for each element that breaks a rule of WCAG 2.2 A and AA.

    The page's policy allows no script of ours, so the debugger injects it.
    """
    if not await page.evaluate("typeof axe !== 'undefined'"):
        await page.evaluate(_source())
    violations: list[dict[str, Any]] = await page.evaluate(_RUN, list(_TAGS))
    return [
        f"axe {one['id']}: {one['help']}; {selector} ({' '.join(summary.split())})"
        for one in violations
        for selector, summary in one["nodes"]
    ]
