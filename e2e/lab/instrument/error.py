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
from e2e.lab.instrument.judge import difference_ms, shift_ms, within
from e2e.lab.instrument.preload import preload
from e2e.lab.instrument.sums import figures, picture_ages

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Page

    from e2e.lab.readings import Readings

LIMIT_MS: Final = 5.0
_ROOT: Final = Path(__file__).parents[3]
_CONFIG: Final = """
[video]
source = "e2e.lab.instrument.cards:LyingVideo"
[audio]
source = "e2e.lab.instrument.cards:LyingAudio"
"""
_SETTLE_S: Final = 3.0
_WITHIN_S: Final = 30.0
_START: Final = (
    "[...document.querySelectorAll('button')]"
    ".find((one) => one.textContent.trim().startsWith('Start'))?.click()"
)
_TWO: Final = ("__waxLabOne", "__waxLabTwo")


async def own_error(seconds: float = 24.0) -> dict[str, Any]:
    """Watch WAX on this machine, without a link, for `seconds` and some to start.

    ``ok`` is whether two instruments on the page agree within 5 ms, and 100 ms that the source's
    clock is behind at times are read as 100 ± 5, for picture and sound. Raises `LabError` when
    server or browser do not work.
    """
    with TemporaryDirectory(prefix="wax-lab-") as folder:
        async with _server(Path(folder)) as url, _page(url) as page:
            one, two = (Instrument(page.evaluate, name=name) for name in _TWO)
            await _until(one.sees_picture, "there is no picture")
            await page.evaluate(_START)
            await _until(one.listen, "there is no sound")
            await asyncio.sleep(_SETTLE_S + seconds)
            first = await one.readings()
            to_ms = first.pictures.at_ms[-1]
            second = await two.readings()
    return {
        **judge(first, second, to_ms),
        "seconds": seconds,
        "read_mean_ms": round(one.cost.mean_ms, 3),
        "read_worst_ms": round(one.cost.worst_ms, 3),
        "pictures_missed": one.cost.missed,
        "sound_output_ms": first.sound_output_ms,
        "not_in_it": "the way from the compositor to the light, and how true the browser's estimate"
        " of its sound output is",
    }


def judge(first: Readings, second: Readings, to_ms: float) -> dict[str, Any]:
    """Compare two readings of one page up to `to_ms`, whose source lied at times."""
    one, two = (figures(read, settle_s=_SETTLE_S, to_ms=to_ms) for read in (first, second))
    pictures = picture_ages(first.pictures)
    heard = bursts(first.sound, first.counters, pictures)
    from_ms = one.from_ms
    shifts = {
        "picture": shift_ms((at - age, age) for at, age in pictures if from_ms <= at <= to_ms),
        "sound": shift_ms(
            (burst.heard_ms - burst.age_ms, burst.age_ms)
            for burst in heard
            if from_ms <= burst.heard_ms <= to_ms
        ),
    }
    ages = {
        "picture": [each.picture_age_ms for each in (one, two)],
        "sound": [each.sound_age_ms for each in (one, two)],
    }
    found: dict[str, Any] = {"limit_ms": LIMIT_MS, "ok": True}
    for kind, (a, b) in ages.items():
        apart_ms = difference_ms(a.p50 if a else None, b.p50 if b else None)
        shift = shifts[kind]
        found["ok"] &= within(apart_ms, 0, LIMIT_MS) and within(shift, LIE_MS, LIMIT_MS)
        found[kind] = {
            "two_instruments_ms": apart_ms if apart_ms is None else round(apart_ms, 2),
            "shift_of_100_read_ms": shift if shift is None else round(shift, 2),
        }
    return found


async def _until(ask: Any, problem: str) -> None:
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
    with log.open("ab") as output:
        process = await asyncio.create_subprocess_exec(
            *[sys.executable, *arguments], cwd=_ROOT, stdout=output, stderr=output
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
        if process.returncode is None:
            process.terminate()
            try:
                await asyncio.wait_for(process.wait(), 10)
            except TimeoutError:
                process.kill()
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
