"""The talking face as a media file that loops: H.264 and FLAC in MP4, exact in its time stamps."""

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

from e2e.lab.face.drawing import HEIGHT, WIDTH, Look, draw
from e2e.lab.face.loudness import loudness_at
from e2e.lab.face.voice import FPS, RATE_HZ, speak

if TYPE_CHECKING:
    from numpy.typing import NDArray

_WIDE_OPEN: Final = 0.98
"""Quantile of the loudness at which the mouth is open as far as it goes."""

_BLINK_S: Final = 0.26
_FIRST_BLINK_S: Final = 1.3
_BLINKS_APART_S: Final = (2.9, 4.3, 3.4, 5.2, 2.5)
_BROWS_S: Final = 0.4
"""The brows follow the voice this slowly."""

_BT601: Final = 6
_LIMITED: Final = 1


def face_file(folder: Path) -> Path:
    """Return the film in `folder`, made if it is not there; its name says what is in it.

    A picture shows the loudness of the voice at its own time stamp. Any number may do this at the
    same time. Raises `NotRunError` where espeak-ng is missing.
    """
    voice = speak()
    content = hashlib.sha256(voice.tobytes())
    for module in ("drawing.py", "film.py", "loudness.py"):
        content.update((Path(__file__).parent / module).read_bytes())
    film = folder / f"face-{content.hexdigest()[:12]}.mp4"
    if not film.exists():
        folder.mkdir(parents=True, exist_ok=True)
        handle, unfinished = tempfile.mkstemp(suffix=".mp4", prefix=".face-", dir=folder)
        os.close(handle)
        try:
            write(Path(unfinished), voice, looks(voice))
            Path(unfinished).chmod(0o644)
            Path(unfinished).replace(film)
        finally:
            Path(unfinished).unlink(missing_ok=True)
    return film


def looks(voice: NDArray[np.int16]) -> list[Look]:
    """How the face looks in each picture; the k-th is shown at k / `FPS` seconds."""
    moments_s = np.arange(len(voice) * FPS // RATE_HZ) / FPS
    loud = loudness_at(voice, RATE_HZ, moments_s)
    mouths = np.clip(loud / np.quantile(loud, _WIDE_OPEN), 0, 1)
    slow = np.ones(round(_BROWS_S * FPS)) / round(_BROWS_S * FPS)
    brows = np.clip(2 * np.convolve(mouths, slow, mode="same") - 0.3, 0, 1)
    lids = _lids(moments_s)
    return [
        Look(mouth=float(mouth), lids=float(lid), brows=float(brow))
        for mouth, lid, brow in zip(mouths, lids, brows, strict=True)
    ]


def write(path: Path, voice: NDArray[np.int16], face: list[Look]) -> None:
    """Write the film; both streams begin at 0 and are equally long."""
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
        for number, look in enumerate(face):
            i420 = cv2.cvtColor(draw(look), cv2.COLOR_BGR2YUV_I420)
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


def _lids(moments_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Blinks at uneven intervals, none about the seam."""
    lids = np.zeros(len(moments_s))
    blink_s, number = _FIRST_BLINK_S, 0
    while blink_s < moments_s[-1] - 1:
        near = np.clip(1 - np.abs(moments_s - blink_s) / (_BLINK_S / 2), 0, 1)
        lids = np.maximum(lids, np.sqrt(near))
        blink_s += _BLINKS_APART_S[number % len(_BLINKS_APART_S)]
        number += 1
    return lids
