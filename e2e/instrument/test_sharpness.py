"""Sharpness: blur counts and so does a picture that stands, age does not."""

from __future__ import annotations

from base64 import b64encode
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest

from e2e.delay.readings import Pictures
from e2e.instrument.instrument import Instrument
from e2e.instrument.sharpness import FROZEN_MS, Look, sharpness, ssim
from e2e.measure.ear import Ear
from e2e.peers.film import FilmCard
from e2e.peers.sizes import VGA, Size

if TYPE_CHECKING:
    from numpy.typing import NDArray

SIZE = VGA[:2]
STAMP_MS = 1_795_249_152_112
AGE_MS = 500.0
SHOWN = Pictures(
    at_ms=[STAMP_MS + AGE_MS],
    stamp_ms=[STAMP_MS],
    received_ms=[None],
    width=[SIZE[0]],
    height=[SIZE[1]],
)


def card(size: Size = VGA) -> NDArray[np.uint8]:
    source = size.camera()
    source.open()
    return source.draw(STAMP_MS)[: size.height]


def figures(luma: NDArray[np.uint8], stood_ms: float = 0.0, of: Size = VGA) -> tuple[float, float]:
    found = sharpness([Look(STAMP_MS + AGE_MS + stood_ms, luma)], SHOWN, of)
    return found["sharpness_ssim"], found["sharpness_psnr_db"]


def scaled(luma: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    return cv2.resize(luma, (width, height), interpolation=cv2.INTER_AREA).astype(np.uint8)


def blurry(sigma: float) -> NDArray[np.uint8]:
    return cv2.GaussianBlur(card(), (0, 0), sigma).astype(np.uint8)


def test_similarity_is_as_defined() -> None:
    """It is 1 for equal pictures, and what the formula says for two greys and half the contrast."""
    noise = np.random.default_rng(1).normal(128, 25, (200, 300)).clip(0, 255).astype(np.uint8)
    assert ssim(noise, noise) == pytest.approx(1)
    grey = np.full((40, 40), 100, np.uint8)
    c1 = 2.55**2
    assert ssim(grey, grey * 2) == pytest.approx((40_000 + c1) / (50_000 + c1), abs=1e-4)
    flat = (128 + (noise.astype(float) - 128) / 2).round().astype(np.uint8)
    assert ssim(noise, flat) == pytest.approx(0.8, abs=0.02)


def test_blur_is_seen_and_age_is_not() -> None:
    """A picture half a second old that is whole has the best figures; each blur has worse ones."""
    assert figures(card()) == pytest.approx((1, 58.92), abs=0.01)
    blurred = [figures(blurry(sigma)) for sigma in (0.5, 1, 2, 4)]
    for figure in zip(*blurred, strict=True):
        assert list(figure) == sorted(figure, reverse=True)
        assert len(set(figure)) == len(figure)


def test_a_smaller_picture_is_enlarged_and_less_sharp() -> None:
    """Each picture is judged at the source's size, whatever its own is."""
    whole, half, quarter = (
        figures(scaled(card(), *size))[0] for size in (SIZE, (320, 240), (160, 120))
    )
    assert whole > half > quarter > 0


def test_a_picture_that_stands_is_compared_with_what_there_is() -> None:
    """From `FROZEN_MS` on, and where the stamp is lost, what is seen is not what is there."""
    assert figures(card(), FROZEN_MS)[0] == pytest.approx(1)
    assert figures(card(), FROZEN_MS + 1)[0] < 0.5
    lost = card().copy()
    lost[: SIZE[1] // 5] = 128
    assert figures(lost)[0] < 0.5
    assert sharpness([], SHOWN, VGA) == {}


def test_a_film_is_compared_with_itself() -> None:
    """It has the card's stamp, another picture than the texture, and another one a second later."""
    film = Size(*SIZE, bitrate_bps=1_000_000, card=FilmCard)
    assert figures(card(film), of=film) == pytest.approx((1, 58.92), abs=0.01)
    assert figures(card(film))[0] < 0.5
    assert figures(card(film), 1000.0, film)[0] < 0.9


async def test_rows_of_the_page_lose_their_padding() -> None:
    """A plane whose rows are longer than the picture is cut to it; all looks are fetched."""
    padded = np.arange(24, dtype=np.uint8).reshape(4, 6)
    seen = {"at_ms": 5.0, "width": 4, "height": 4, "stride": 6}
    left: list[Any] = [{**seen, "luma": b64encode(padded.tobytes()).decode()}] * 2 + [None]

    async def evaluate(_: str) -> Any:
        return left.pop(0)

    first, _ = await Instrument(evaluate, Ear({})).looks()
    assert first.at_ms == 5
    assert (first.luma == padded[:, :4]).all()
