"""The talking face through the real server and a real browser."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from e2e.harness.viewer import EARS
from e2e.lab.face import face_file, lip_lag
from e2e.lab.readings import Pictures, Readings, Sound

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from e2e.conftest import OpenViewer, Serve

WATCHED_S = 10

LOOK = """
(seconds) => new Promise((resolve) => {
  const video = document.querySelector("video");
  const strip = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const seen = { at_ms: [], mouth: [], width: [], stamp_ms: [] };
  const end = performance.now() + 1000 * seconds;
  const onFrame = (now, { width, height }) => {
    strip.canvas.width = 2;
    strip.canvas.height = height;
    strip.drawImage(video, width / 2 - 1, 0, 2, height, 0, 0, 2, height);
    const { data } = strip.getImageData(0, 0, 2, height);
    let rows = 0;
    for (let i = 0; i < data.length; i += 8)
      if (data[i] > 180 && data[i + 1] < 90 && data[i + 2] < 90) rows++;
    seen.at_ms.push(performance.timeOrigin + now);
    seen.mouth.push(rows / (0.25 * height));
    seen.width.push(width);
    seen.stamp_ms.push(null);
    if (now < end) video.requestVideoFrameCallback(onFrame);
    else resolve(seen);
  };
  video.requestVideoFrameCallback(onFrame);
})
"""


@pytest.mark.timeout(90)
async def test_lips_and_voice_arrive_together(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer, voice: NDArray[np.int16]
) -> None:
    """A viewer of the face sees its mouth move from shut to wide, and hears the voice to it."""
    film = await asyncio.to_thread(face_file, tmp_path / "film")
    settings = f'[video]\nsource = "{film}"\n[audio]\nsource = "{film}"\n'
    async with serve(tmp_path, settings) as server:
        viewer = await open_viewer(server, **EARS)
        await viewer.listen()
        pictures = Pictures(**await viewer.page.evaluate(LOOK, WATCHED_S))
        blocks = await viewer.heard()
    sound = Sound(
        start_ms=[block.start_ms for block in blocks],
        rms=[block.rms for block in blocks],
        tone=[block.tone for block in blocks],
        burst=[block.burst for block in blocks],
    )
    readings = Readings(opened_ms=pictures.at_ms[0], pictures=pictures, sound=sound)
    openings = [mouth for mouth in pictures.mouth if mouth is not None]
    assert min(openings) == 0
    assert 0.7 < max(openings) <= 1.1
    found = lip_lag(readings, from_ms=pictures.at_ms[0], to_ms=pictures.at_ms[-1])
    print(f"face: {found}, {len(openings)} pictures (voice late is positive)")
    assert found is not None
    assert found.correlation > 0.6
