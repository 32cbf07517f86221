"""The instrument's own error, measured: two of them on one page, and a source that lies."""

from __future__ import annotations

import asyncio
import os
import sys
import time
from contextlib import asynccontextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from playwright.async_api import Error as PlaywrightError
from playwright.async_api import async_playwright

from e2e.harness.chromium import FLAGS, NAMES
from e2e.harness.server import free_port
from e2e.lab.browsers.window import installed
from e2e.lab.errors import LabError
from e2e.lab.instrument.bursts import bursts
from e2e.lab.instrument.cards import LIE_MS
from e2e.lab.instrument.instrument import Instrument
from e2e.lab.instrument.judge import difference_ms, is_clear, shift, within
from e2e.lab.instrument.preload import preload
from e2e.lab.instrument.sums import figures, picture_ages

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from playwright.async_api import Page

    from e2e.lab.readings import Readings

LIMIT_MS: Final = 5.0
_ROOT: Final = Path(__file__).parents[3]
# A small picture, so that the encoder's own unrest is small.
_CONFIG: Final = """
[video]
source = "e2e.lab.instrument.cards:LyingVideo"
width = 320
height = 240
renditions = [{ width = 320, height = 240, fps = 30.0, bitrate_bps = 350_000 }]
[audio]
source = "e2e.lab.instrument.cards:LyingAudio"
"""
_SETTLE_S: Final = 3.0
_LEAST_S: Final = 15.0
_MORE_S: Final = 5.0
_MOST_S: Final = 45.0
_WITHIN_S: Final = 30.0
_START: Final = (
    "[...document.querySelectorAll('button')]"
    ".find((one) => one.textContent.trim().startsWith('Start'))?.click()"
)
_TWO: Final = ("__waxLabOne", "__waxLabTwo")


async def own_error() -> dict[str, Any]:
    """Watch WAX on this machine, without a link, for 15 s and some to start.

    ``ok`` is whether two instruments on the page agree within 5 ms, and 100 ms that the source's
    clock is behind at times are read as 100 ± 5, for picture and sound. On a busy machine, whose
    unrest spreads the readings, it goes on for up to 45 s, until they tell. Raises `LabError` when
    server or browser do not work.
    """
    with TemporaryDirectory(prefix="wax-lab-") as folder:
        async with _server(Path(folder)) as url, _page(url) as page:
            one, two = (Instrument(page.evaluate, name=name) for name in _TWO)
            await _until(one.sees_picture, "there is no picture")
            await page.evaluate(_START)
            await _until(one.listen, "there is no sound")
            began_s = time.monotonic()
            await asyncio.sleep(_SETTLE_S + _LEAST_S)
            while True:
                first = await one.readings()
                second = await two.readings()
                found, certain = judge(first, second)
                watched_s = time.monotonic() - began_s - _SETTLE_S
                if certain or watched_s >= _MOST_S:
                    break
                await asyncio.sleep(_MORE_S)
    return {
        **found,
        "seconds": round(watched_s, 1),
        "read_mean_ms": round(one.cost.mean_ms, 3),
        "read_worst_ms": round(one.cost.worst_ms, 3),
        "pictures_missed": one.cost.missed,
        "sound_output_ms": first.sound_output_ms,
        "not_in_it": "the way from the compositor to the light, and how true the browser's estimate"
        " of its sound output is",
    }


def judge(first: Readings, second: Readings) -> tuple[dict[str, Any], bool]:
    """Compare two readings of one page whose source lied at times; and whether they tell."""
    to_ms = min((read.pictures.at_ms or [read.opened_ms])[-1] for read in (first, second))
    one, two = (figures(read, settle_s=_SETTLE_S, to_ms=to_ms) for read in (first, second))
    pictures = picture_ages(first.pictures)
    heard = bursts(first.sound, first.counters, pictures)
    shifts = {
        "picture": shift((at - age, age) for at, age in pictures if one.from_ms <= at <= to_ms),
        "sound": shift(
            (burst.heard_ms - burst.age_ms, burst.age_ms)
            for burst in heard
            if one.from_ms <= burst.heard_ms <= to_ms
        ),
    }
    ages = {
        "picture": [each.picture_age_ms for each in (one, two)],
        "sound": [each.sound_age_ms for each in (one, two)],
    }
    found: dict[str, Any] = {"limit_ms": LIMIT_MS, "ok": True}
    for kind, (a, b) in ages.items():
        apart_ms = difference_ms(a.p50 if a else None, b.p50 if b else None)
        read = shifts[kind]
        shift_ms = read.ms if read else None
        found["ok"] &= within(apart_ms, 0, LIMIT_MS) and within(shift_ms, LIE_MS, LIMIT_MS)
        found[kind] = {
            "two_instruments_ms": _rounded(apart_ms),
            "shift_of_100_read_ms": _rounded(shift_ms),
            "uncertain_ms": _rounded(read.uncertain_ms if read else None),
        }
    certain = all(read and is_clear(read, LIE_MS, LIMIT_MS) for read in shifts.values())
    return found, certain


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 2)


async def _until(ask: Callable[[], Awaitable[bool]], problem: str) -> None:
    until_s = time.monotonic() + _WITHIN_S
    while not await ask():
        if time.monotonic() > until_s:
            raise LabError(f"the instrument's own error: {problem} within {_WITHIN_S:g} s")
        await asyncio.sleep(0.1)


@asynccontextmanager
async def _server(folder: Path) -> AsyncIterator[str]:
    config, log = folder / "wax.toml", folder / "server.log"
    config.write_text(_CONFIG, encoding="utf-8")
    port = free_port()
    url = f"http://127.0.0.1:{port}"
    arguments = ["-m", "wax", "--config", str(config), "--host", "127.0.0.1", "--port", str(port)]
    # It runs outside any link, whose leftovers are found; so it must end with us, even if killed.
    tether = [sys.executable, "-m", "e2e.lab.instrument.tether"]
    with log.open("ab") as output:
        process = await asyncio.create_subprocess_exec(
            *[*tether, sys.executable, *arguments],
            cwd=_ROOT,
            stdin=asyncio.subprocess.PIPE,
            stdout=output,
            stderr=output,
            start_new_session=True,  # Ctrl-C is for us alone: we end it when we are ready
        )
    try:

        async def serves() -> bool:
            if process.returncode is not None:
                said = log.read_text(encoding="utf-8", errors="replace")[-2000:]
                raise LabError(f"the server ended at its start with {process.returncode}:\n{said}")
            try:
                async with aiohttp.ClientSession() as http, http.get(f"{url}/healthz") as answer:
                    return answer.status == 200
            except aiohttp.ClientError:
                return False

        await _until(serves, "the server does not serve")
        yield url
    finally:
        assert process.stdin is not None
        process.stdin.close()
        await process.wait()


@asynccontextmanager
async def _page(url: str) -> AsyncIterator[Page]:
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    path = installed("WAX_CHROMIUM", NAMES)
    async with async_playwright() as playwright:
        try:
            browser = await playwright.chromium.launch(
                executable_path=path, args=[*FLAGS, *sandbox]
            )
            try:
                page = await browser.new_page()
                for name in _TWO:
                    await page.add_init_script(preload(name))
                await page.goto(url)
                yield page
            finally:
                await browser.close()
        except PlaywrightError as error:
            raise LabError(f"the instrument's own error: in Chromium: {error.message}") from error
