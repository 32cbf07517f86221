"""The film as a media file that loops: H.264 and FLAC in MP4, exact in its time stamps."""

from __future__ import annotations

import hashlib
import os
import tempfile
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import av
import cv2
import numpy as np

from e2e.delay.talking_head.drawing import HEIGHT, WIDTH, draw
from e2e.delay.talking_head.loudness import loudness_at
from e2e.delay.talking_head.voice import FPS, RATE_HZ, speak

if TYPE_CHECKING:
    from numpy.typing import NDArray

_WIDE_OPEN: Final = 0.98
"""Quantile of the loudness at which the mouth is open as far as it goes."""
_BT601: Final = 6
_LIMITED: Final = 1


def film_file(folder: Path) -> Path:
    """Return the film in `folder`, made if it is not there; its name says what is in it.

    A picture shows the loudness of the voice at its own time stamp. Any number may do this at the
    same time. Raises `NotRunError` where espeak-ng is missing.
    """
    voice = speak()
    content = hashlib.sha256(voice.tobytes())
    for module in ("drawing.py", "film.py", "loudness.py"):
        content.update((Path(__file__).parent / module).read_bytes())
    film = folder / f"talking-head-{content.hexdigest()[:12]}.mp4"
    if not film.exists():
        folder.mkdir(parents=True, exist_ok=True)
        handle, unfinished = tempfile.mkstemp(suffix=".mp4", prefix=".film-", dir=folder)
        os.close(handle)
        try:
            _write(Path(unfinished), voice)
            Path(unfinished).chmod(0o644)
            Path(unfinished).replace(film)
        finally:
            Path(unfinished).unlink(missing_ok=True)
    return film


def openings(voice: NDArray[np.int16]) -> NDArray[np.float64]:
    """How far the mouth is open in each picture; the k-th is shown at k / `FPS` seconds."""
    moments_s = np.arange(len(voice) * FPS // RATE_HZ) / FPS
    loud = loudness_at(voice, RATE_HZ, moments_s)
    return np.asarray(np.clip(loud / np.quantile(loud, _WIDE_OPEN), 0, 1))


def _write(path: Path, voice: NDArray[np.int16]) -> None:
    """Write it; both streams begin at 0 and are equally long."""
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        pictures: Any = container.add_stream("libx264", rate=FPS)
        pictures.width, pictures.height, pictures.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        pictures.codec_context.time_base = Fraction(1, FPS)
        pictures.codec_context.colorspace = _BT601
        pictures.codec_context.color_range = _LIMITED
        # No picture waits for a later one, and a server that fell behind soon finds a keyframe.
        pictures.options = {"preset": "ultrafast", "crf": "14", "bf": "0", "g": str(FPS)}
        sound: Any = container.add_stream("flac", rate=RATE_HZ, layout="mono")
        per_picture = RATE_HZ // FPS
        for number, opening in enumerate(openings(voice)):
            i420 = cv2.cvtColor(draw(float(opening)), cv2.COLOR_BGR2YUV_I420)
            picture = av.VideoFrame.from_ndarray(np.asarray(i420, np.uint8), format="yuv420p")
            picture.pts, picture.time_base = number, Fraction(1, FPS)
            container.mux(pictures.encode(picture))
            start = number * per_picture
            piece = av.AudioFrame.from_ndarray(
                voice[None, start : start + per_picture], format="s16", layout="mono"
            )
            piece.sample_rate, piece.pts = RATE_HZ, start
            piece.time_base = Fraction(1, RATE_HZ)
            container.mux(sound.encode(piece))
        container.mux(pictures.encode(None))
        container.mux(sound.encode(None))
