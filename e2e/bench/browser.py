"""Headless Chromium, and what is read inside the page."""

from __future__ import annotations

import os
import shutil
import time
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from playwright.sync_api import Error as PlaywrightError
from playwright.sync_api import sync_playwright

from e2e.bench.errors import BenchError
from e2e.harness.chromium import FLAGS, NAMES

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser, Page

FIRST_FRAME_JS = """
(() => {
  window.waxBenchFirstFrameMs = new Promise((resolve) => {
    const watch = (video) => {
      if (video.waxBench) return;
      video.waxBench = true;
      video.requestVideoFrameCallback(() => resolve(performance.now()));
    };
    new MutationObserver(() => document.querySelectorAll("video").forEach(watch))
      .observe(document, { childList: true, subtree: true });
    setTimeout(() => resolve(null), 20_000);
  });
})();
"""
"""Promises when the first video frame is presented, ms since the navigation began; else null."""

KEYS_JS = """
(() => {
  window.waxBenchKeys = [];
  const note = (event) => {
    if (!event.isTrusted || event.repeat) return;
    window.waxBenchKeys.push([event.type, event.code, event.timeStamp, performance.now()]);
  };
  addEventListener("keydown", note, { capture: true });
  addEventListener("keyup", note, { capture: true });
})();
"""
"""Notes each key that goes down or up: when the browser made the event, and when it arrived."""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start it; raises `BenchError` when there is none, or when it fails inside the block."""
    path = os.environ.get("WAX_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        raise BenchError("no Chromium found: install the package chromium, or set WAX_CHROMIUM")
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=path, args=["--no-sandbox", *FLAGS]
            )
            try:
                yield browser
            finally:
                browser.close()
    except PlaywrightError as error:
        raise BenchError(f"in Chromium: {error.message}") from error


@contextmanager
def fresh_page(browser: Browser, script: str) -> Iterator[Page]:
    """Open a page without a past; `script` runs in it before any script of the site."""
    context = browser.new_context(locale="en-GB")
    context.set_default_timeout(20_000)
    try:
        context.add_init_script(script)
        yield context.new_page()
    finally:
        context.close()


@dataclass(frozen=True, slots=True)
class PageClock:
    """CLOCK_MONOTONIC minus the page's ``performance.now()``, ms, known to ± `error_ms`."""

    offset_ms: float
    error_ms: float


def page_clock(page: Page, tries: int = 60) -> PageClock:
    """Ask the page for its time; the quickest answer bounds the error by half its round trip."""
    clocks = []
    for _ in range(tries):
        before_ms = time.monotonic() * 1000
        page_ms: Any = page.evaluate("performance.now()")
        after_ms = time.monotonic() * 1000
        middle_ms, error_ms = (before_ms + after_ms) / 2, (after_ms - before_ms) / 2
        clocks.append(PageClock(offset_ms=middle_ms - float(page_ms), error_ms=error_ms))
    return min(clocks, key=lambda clock: clock.error_ms)
