"""The film through the real server and a real browser, read by the lab's instrument."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from e2e.delay.talking_head import film_file, lip_lag
from e2e.harness.missing import needed
from e2e.harness.wait import eventually
from e2e.instrument import PRELOAD, Instrument

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray
    from playwright.async_api import Browser

    from e2e.conftest import Serve
    from e2e.measure.ear import Ear

WATCHED_S = 10


@pytest.mark.timeout(90)
async def test_lips_and_voice_arrive_together(
    serve: Serve, tmp_path: Path, chromium: Browser, ear: Ear | None, voice: NDArray[np.int16]
) -> None:
    """A viewer of the film sees its mouth move from shut to wide, and hears the voice to it."""
    film = await asyncio.to_thread(film_file, tmp_path / "film")
    settings = f'[video]\nsource = "{film}"\n[audio]\nsource = "{film}"\n'
    context = await chromium.new_context()
    try:
        async with serve(tmp_path, settings) as server:
            await context.add_init_script(PRELOAD)
            page = await context.new_page()
            instrument = Instrument(page.evaluate, needed(ear))
            await page.goto(server.url)
            await page.get_by_role("button", name="Turn sound on").first.click()
            await eventually(instrument.sees_picture, "the picture plays")
            assert await instrument.hears(within_s=10), "no sound"
            await asyncio.sleep(WATCHED_S)
            readings = await instrument.readings()
    finally:
        await context.close()
    openings = [mouth for mouth in readings.pictures.mouth if mouth is not None]
    assert min(openings) == 0
    assert 0.7 < max(openings) <= 1.1
    to_ms = readings.pictures.at_ms[-1]
    found = lip_lag(readings, from_ms=to_ms - 1000 * WATCHED_S, to_ms=to_ms)
    assert found is not None
    assert found.correlation > 0.6
