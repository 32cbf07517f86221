"""The automatic ladder of renditions, for any camera."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from wax.config.ladder import BESIDE, DRIVING, ladder
from wax.config.video import RenditionSettings

LYING = st.tuples(st.integers(16, 1920), st.integers(16, 1080))
SIZES = st.one_of(LYING, LYING.map(lambda size: size[::-1])).map(
    lambda halves: (2 * halves[0], 2 * halves[1])
)


def told(width: int, height: int, fps: float = 30.0) -> list[str]:
    return [f"{one.width}x{one.height}@{one.fps:g}" for one in ladder(width, height, fps)]


@given(
    SIZES,
    st.floats(1.0, 240.0),
    st.sampled_from([DRIVING, BESIDE]),
)
@example((1280, 720), 30.0, DRIVING)
@example((1080, 1920), 30.0, DRIVING)
@example((2560, 1080), 30.0, DRIVING)
@example((720, 720), 30.0, DRIVING)
@example((32, 32), 1.0, BESIDE)
@example((3840, 2160), 60.0, DRIVING)
@example((2160, 3840), 60.0, BESIDE)
def test_every_camera_has_a_ladder_of_its_own_shape(
    size: tuple[int, int], fps: float, steps: tuple[object, ...]
) -> None:
    """Each step is valid, even, of the camera's shape, and cheaper than the one above."""
    width, height = size
    found = ladder(width, height, fps, steps)  # type: ignore[arg-type]
    assert found[0][:2] == (width, height)
    assert len(found) <= len(steps) + 1
    for one in found:
        RenditionSettings(**one._asdict())
        assert one.fps <= min(fps, 30.0)
        scale = one.width / width if width > height else one.height / height
        assert abs(one.width - width * scale) <= 1
        assert abs(one.height - height * scale) <= 1
    for above, below in pairwise(found):
        assert below.bitrate_bps < above.bitrate_bps
        assert (below.width * below.height, below.fps) <= (above.width * above.height, above.fps)


@pytest.mark.parametrize(
    ("size", "sizes"),
    [
        (
            (640, 480),
            "640x480@30 640x480@30 320x240@30 320x240@15 160x120@15 160x120@10",
        ),
        (
            (1280, 720),
            "1280x720@30 960x540@30 640x360@30 320x180@30 320x180@15 160x90@15 160x90@10",
        ),
        (
            (480, 640),
            "480x640@30 480x640@30 240x320@30 240x320@15 120x160@15 120x160@10",
        ),
    ],
)
def test_the_usual_cameras_have_these_sizes(size: tuple[int, int], sizes: str) -> None:
    """A webcam's ladder, in VGA, in HD and on its side, ends with what a modem carries."""
    assert told(*size) == sizes.split()
    assert ladder(*size, 30.0)[-1].bitrate_bps == 16_000


def test_the_rate_follows_the_pixels_and_the_pictures() -> None:
    """HD has 2.5 times VGA's bits, and half the pictures have half of them."""
    assert [ladder(640, 480, fps)[0].bitrate_bps for fps in (30, 15)] == [1_000_000, 500_000]
    assert ladder(1280, 720, 30)[0].bitrate_bps == 2_500_000
