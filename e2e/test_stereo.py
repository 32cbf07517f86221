"""Stereo, as it sounds outside the browser: the sides are separate."""

from __future__ import annotations

import wave
from typing import TYPE_CHECKING

import numpy as np
import pytest
import tomlkit
from playwright.async_api import expect

from e2e.harness import toml
from e2e.harness.wait import eventually
from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.viewer import Viewer

LOUD, SOFT = 6000.0, 200.0
SECONDS_EACH = 0.8
WINDOW = SAMPLE_RATE_HZ // 10
APART = 5.0
"""The source is 30 times as loud on one side."""
ENOUGH = 5
"""Each side is loud for eight consecutive tenths of a second."""


def sides(viewer: Viewer) -> NDArray[np.float64]:
    """Return how loud each ear was in each tenth of a second, ``(n, 2)``."""
    heard = viewer.ears().astype(np.float64)
    whole = heard[: len(heard) // WINDOW * WINDOW].reshape(-1, WINDOW, 2)
    return np.asarray(whole.std(axis=1))


@pytest.mark.full
@pytest.mark.timeout(120)
async def test_left_and_right_arrive_apart(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """Noise that changes sides is heard on its side, and the meters show it."""
    loud, soft = (np.full(round(SECONDS_EACH * SAMPLE_RATE_HZ), one) for one in (LOUD, SOFT))
    both = np.column_stack((np.append(loud, soft), np.append(soft, loud)))
    both *= np.random.default_rng(5).normal(0.0, 1.0, both.shape)
    noise = tmp_path / "sides.wav"
    with wave.open(str(noise), "wb") as file:
        file.setparams((2, 2, SAMPLE_RATE_HZ, 0, "NONE", ""))
        file.writeframes(np.clip(both, -32768, 32767).astype("<i2").tobytes())
    settings = toml.merged(toml.MEDIA, {"audio": {"source": str(noise)}})
    async with serve(tmp_path, tomlkit.dumps(settings)) as server:
        viewer = await open_viewer(server)
        await viewer.listen()
        await viewer.details_say("kbit/s stereo", within_s=30)
        viewer.forget()

        async def change_sides() -> bool:
            left, right = sides(viewer)[-round(20 * SECONDS_EACH) :].T  # once to and fro
            return all(
                np.count_nonzero(one > APART * other) >= ENOUGH
                for one, other in ((left, right), (right, left))
            )

        await eventually(change_sides, "each side is heard apart", within_s=20, every_s=0.2)
        for side in ("left", "right"):
            meter = viewer.page.get_by_role("meter", name=f"Sound level, {side}", exact=True)
            await expect(meter).to_be_visible()
