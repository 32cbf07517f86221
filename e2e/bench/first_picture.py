"""First picture: from the start of the page's navigation to its first presented video frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from e2e.bench.browser import FIRST_FRAME_JS, chromium, fresh_page
from e2e.bench.errors import BenchError
from e2e.bench.servers import Server
from e2e.bench.spread import Spread, spread

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from e2e.bench.plan import Plan
    from e2e.bench.servers import Side

PAUSE_MS = 300


@dataclass(frozen=True, slots=True)
class FirstPicture:
    """One side. `cold_ms` is the first page of a new browser process, not among the others.

    Stock includes what aiortc waits for the browser's mDNS names: a second where nobody answers
    multicast, as inside most containers.
    """

    cold_ms: float
    warm_ms: Spread
    each_ms: list[float]


def measure(side: Side, plan: Plan) -> FirstPicture:
    """Every page has a context of its own: no cache, no storage, no open connection."""
    with Server(side) as server, chromium() as browser:
        cold_ms = _load(browser, server.url)
        each_ms = [_load(browser, server.url) for _ in range(plan.joins)]
    return FirstPicture(cold_ms=cold_ms, warm_ms=spread(each_ms), each_ms=each_ms)


def _load(browser: Browser, url: str) -> float:
    with fresh_page(browser, FIRST_FRAME_JS) as page:
        page.goto(url, wait_until="commit")
        first_ms = page.evaluate("window.waxBenchFirstFrameMs")
        if first_ms is None:
            raise BenchError(f"{url}: no picture in 20 s")
        page.goto("about:blank")
        # The server is given time to let the viewer go, so that pages do not overlap.
        page.wait_for_timeout(PAUSE_MS)
    return float(first_ms)
