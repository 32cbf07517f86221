"""The film as a file: what a server gets to play, and what can still be read of it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from typing import TYPE_CHECKING

import av
import cv2
import numpy as np
import pytest

from e2e.delay.talking_head import film_file
from e2e.delay.talking_head.drawing import draw
from e2e.delay.talking_head.film import openings
from e2e.delay.talking_head.voice import FPS, RATE_HZ
from e2e.measure.errors import NotRunError
from wax.capture.letterbox import fit_frame

if TYPE_CHECKING:
    from pathlib import Path

    from av.video.frame import VideoFrame
    from numpy.typing import NDArray


@pytest.fixture(scope="session")
def film(voice: NDArray[np.int16], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return film_file(tmp_path_factory.mktemp("film"))


@pytest.fixture(scope="session")
def pictures(film: Path) -> list[VideoFrame]:
    with av.open(str(film)) as container:
        return list(container.decode(video=0))


def opening(i420: NDArray[np.uint8]) -> float:
    """Read the mouth as the instrument does: rows of red in the middle, by a quarter of all."""
    bgr = np.asarray(cv2.cvtColor(i420, cv2.COLOR_YUV2BGR_I420), np.uint8)
    height, width = bgr.shape[:2]
    blue, green, red = (bgr[:, width // 2 - 1 : width // 2 + 1, place] for place in range(3))
    mouth = ((red > 180) & (green < 90) & (blue < 90)).mean(axis=1)
    return float(mouth[round(0.55 * height) : round(0.85 * height)].sum() / (0.25 * height))


def test_nothing_but_the_mouth_is_red() -> None:
    """Red is found between 0.55 and 0.85 of the height only, about the middle, as high as asked."""
    for asked in np.linspace(0, 1, 21):
        blue, green, red = np.moveaxis(draw(asked), 2, 0)
        rows, columns = np.nonzero((red > 180) & (green < 90) & (blue < 90))
        if asked < 0.03:
            assert not len(rows)
            continue
        assert rows.min() >= 0.55 * 480
        assert rows.max() < 0.85 * 480
        assert abs(columns.mean() - 319.5) < 1
        assert abs(len(np.unique(rows)) / 120 - asked) <= 2 / 120


def test_both_streams_are_exact(
    voice: NDArray[np.int16], film: Path, pictures: list[VideoFrame]
) -> None:
    """Each picture and each sample lies at its own time; both begin at 0 and end together."""
    assert [picture.time for picture in pictures] == [k / FPS for k in range(len(pictures))]
    heard: list[NDArray[np.int16]] = []
    with av.open(str(film)) as container:
        for frame in container.decode(audio=0):
            assert frame.time_base == Fraction(1, RATE_HZ)
            assert frame.pts == sum(len(piece) for piece in heard)
            heard.append(np.asarray(frame.to_ndarray()[0], np.int16))
        assert container.start_time == 0
        assert container.duration is not None
        assert abs(container.duration / 1e6 - len(voice) / RATE_HZ) < 1e-3
    assert np.array_equal(np.concatenate(heard), voice)
    assert Fraction(len(pictures), FPS) == Fraction(len(voice), RATE_HZ)


def test_lips_show_the_loudness_of_their_own_moment(
    voice: NDArray[np.int16], pictures: list[VideoFrame]
) -> None:
    """What is read off a picture fits the sound about its time stamp best, to the millisecond."""
    read = np.array([opening(np.asarray(picture.to_ndarray(), np.uint8)) for picture in pictures])
    power = np.pad((voice / 32768.0) ** 2, RATE_HZ)
    sums = np.concatenate([[0.0], np.cumsum(power)])
    moments = RATE_HZ + np.arange(len(read)) * RATE_HZ // FPS
    half = RATE_HZ * 8 // 1000

    def fit(shift_ms: int) -> float:
        middle = moments + shift_ms * RATE_HZ // 1000
        rms = np.sqrt((sums[middle + half] - sums[middle - half]) / (2 * half))
        return float(np.corrcoef(read, rms**0.6)[0, 1])

    fits = {shift_ms: fit(shift_ms) for shift_ms in range(-300, 301)}
    best = max(fits, key=lambda shift_ms: fits[shift_ms])
    assert fits[best] > 0.97
    assert abs(best) <= 1


def test_the_voice_fits_itself_at_no_other_shift(voice: NDArray[np.int16]) -> None:
    """Between 0.25 s and 1.5 s away the opening correlates with itself by less than 0.2."""
    mouths = openings(voice)
    assert 20 <= len(mouths) / FPS <= 40
    mouths -= mouths.mean()
    sidelobes = [
        mouths @ np.roll(mouths, shift) / (mouths @ mouths)
        for shift in range(round(0.25 * FPS), round(1.5 * FPS))
    ]
    assert max(sidelobes) < 0.2


def test_the_seam_of_the_loop_is_silent(voice: NDArray[np.int16]) -> None:
    """At both ends half a second is silence behind closed lips."""
    half = RATE_HZ // 2
    assert not voice[:half].any()
    assert not voice[-half:].any()
    assert openings(voice)[0] == openings(voice)[-1] == 0


@pytest.mark.parametrize(
    ("size", "fps", "bitrate_bps"),
    [((166, 130), 10, 640_000), ((160, 120), 5, 20_000), ((640, 480), 30, 300_000)],
)
def test_the_mouth_survives_vp8(
    pictures: list[VideoFrame],
    voice: NDArray[np.int16],
    size: tuple[int, int],
    fps: int,
    bitrate_bps: int,
) -> None:
    """The opening is read within 0.1 from the thesis's keyframes and from a modem's pictures."""
    width, height = size
    encoder = av.CodecContext.create("libvpx", "w")
    encoder.width, encoder.height, encoder.pix_fmt = width, height, "yuv420p"
    encoder.bit_rate, encoder.time_base = bitrate_bps, Fraction(1, fps)
    encoder.options = {"deadline": "realtime", "cpu-used": "8", "lag-in-frames": "0"}
    encoder.options |= {"g": "1" if size == (166, 130) else "3000"}
    decoder = av.CodecContext.create("vp8", "r")
    apart = FPS // fps
    asked = openings(voice)[:450:apart]
    read = []
    for number, picture in enumerate(pictures[:450:apart]):
        frame = av.VideoFrame.from_ndarray(fit_frame(picture, width, height), format="yuv420p")
        frame.pts, frame.time_base = number, Fraction(1, fps)
        for packet in encoder.encode(frame):
            read += [
                opening(np.asarray(seen.to_ndarray(), np.uint8)) for seen in decoder.decode(packet)
            ]
    assert len(read) == len(asked)
    assert np.abs(np.array(read) - asked).max() < 0.1
    assert max(seen for seen, mouth in zip(read, asked, strict=True) if mouth == 0) == 0


def test_two_runs_make_one_file(voice: NDArray[np.int16], tmp_path: Path) -> None:
    """Made twice at the same time, there is one whole film, and a third run makes none."""
    folder = tmp_path / "new"
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(film_file, [folder, folder])
    assert first == second
    assert list(folder.iterdir()) == [first]
    with av.open(str(first)) as container:
        assert container.streams.video[0].frames == len(voice) * FPS // RATE_HZ
    made_ns = first.stat().st_mtime_ns
    assert film_file(folder) == first
    assert first.stat().st_mtime_ns == made_ns


def test_without_espeak_a_sentence_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where espeak-ng is missing, `NotRunError` says what to install and nothing is left behind."""
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NotRunError, match=r"^The film has no voice: .*install.*\.$"):
        film_file(tmp_path / "new")
    assert not (tmp_path / "new").exists()
