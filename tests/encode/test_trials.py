"""Trials of encoders: requirements are checked, and no trial hangs or ends the server."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.encode.encoders import GOOD, HIGH, LARGE, LATE, SMALL

from wax.capture.source import Picture
from wax.config.video import VideoSettings
from wax.encode.hardware import HARDWARE, Hardware, HardwareEncoder, HardwareError
from wax.encode.trial import likeness, run, waves
from wax.encode.trials import try_all

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.config.video import RenditionSettings


def patient(renditions: Iterable[RenditionSettings]) -> list[RenditionSettings]:
    """Use so low a frame rate that no machine is too slow."""
    return [one.model_copy(update={"fps": 1.0}) for one in renditions]


BOTH = patient([LARGE, SMALL])


@pytest.mark.system
def test_a_good_one_passes_in_a_process_of_its_own() -> None:
    """Each rendition of the default ladder is encoded, decoded, compared and timed."""
    ladder = patient(VideoSettings().renditions)
    (trial,) = try_all([GOOD], ladder, limit_s=30)
    assert trial.problem is None
    assert not trial.refused
    assert set(trial.ms) == {one.name for one in ladder}
    assert all(0 < ms < 1000 for ms in trial.ms.values())


@pytest.mark.parametrize(
    ("hardware", "why"),
    [(LATE, "0 packets for one picture"), (HIGH, "profile 100 instead of baseline")],
)
def test_one_that_does_not_keep_it_is_refused(hardware: Hardware, why: str) -> None:
    """An encoder that delays pictures or has another profile fails with a reason."""
    trial = run(hardware, BOTH)
    assert trial.problem is not None
    assert why in trial.problem
    assert not trial.ms


def test_a_slow_one_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """An encoder that takes longer than a picture lasts fails."""
    ticks = iter(range(10_000))
    monkeypatch.setattr("wax.encode.trial.time.perf_counter", lambda: next(ticks) / 10)
    trial = run(GOOD, [SMALL])
    assert trial.problem == "it is too slow: 100 ms a picture"


def test_a_wrong_picture_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """An encoder whose decoded picture differs from its input fails."""
    size = (SMALL.width, SMALL.height)
    green = np.zeros((size[1] * 3 // 2, size[0]), np.uint8)
    encode = HardwareEncoder.encode
    monkeypatch.setattr(
        HardwareEncoder,
        "encode",
        lambda self, picture, *, keyframe: encode(
            self, Picture(green, picture.captured_s), keyframe=keyframe
        ),
    )
    assert run(GOOD, [SMALL]).problem == "its pictures do not look like what they show"


def test_likeness_sees_what_is_wrong() -> None:
    """Equal pictures have likeness 1; grey, inverted and colour-swapped ones are not alike."""
    shown = waves(160, 120, 3)
    assert likeness(shown, shown) == pytest.approx(1.0)
    assert likeness(shown, np.full_like(shown, 128)) == 0.0
    exchanged = np.concatenate([shown[:120], shown[150:], shown[120:150]])
    assert likeness(shown, exchanged) < 0.5
    assert likeness(shown, shown[::-1]) < 0.5


@pytest.mark.parametrize("pixels", ["yuv420p", "nv12"])
def test_a_size_with_odd_rows_of_chroma_passes(pixels: str) -> None:
    """A size with odd rows of chroma, such as 480×270, is tried like any other."""
    low = SMALL.model_copy(update={"width": 96, "height": 54})
    trial = run(replace(GOOD, pixels=pixels), patient([low]))
    assert trial.problem is None


def test_one_rendition_may_fail_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """An encoder that fails in one size works in others, with a reason for that one."""
    encode = HardwareEncoder.encode

    def too_small(self: HardwareEncoder, picture: Picture, *, keyframe: bool) -> object:
        if picture.width == SMALL.width:
            raise HardwareError("it takes no pictures so small")
        return encode(self, picture, keyframe=keyframe)

    monkeypatch.setattr(HardwareEncoder, "encode", too_small)
    trial = run(GOOD, BOTH)
    assert trial.problem is None
    assert set(trial.ms) == {LARGE.name}
    assert trial.refused == {SMALL.name: "it takes no pictures so small"}


@pytest.mark.system
def test_what_is_not_here_says_why() -> None:
    """The real candidates of a machine without them fail with their own error texts."""
    found = try_all(HARDWARE, BOTH, limit_s=30)
    assert [one.encoder for one in found] == [one.name for one in HARDWARE]
    assert all(one.problem or one.ms for one in found)


def test_what_pyav_lacks_is_not_started() -> None:
    """An encoder that PyAV lacks is reported without a process."""
    (trial,) = try_all([Hardware("h264_nonsense", "yuv420p")], BOTH, command=["-c", "1/0"])
    assert trial.problem == "PyAV is built without it here"


HANGS = "import sys, time; sys.stdin.read(); print('{', flush=True); time.sleep(60)"
CRASHES = "import os, sys; sys.stdin.read(); os.kill(os.getpid(), 11)"
LEAVES = "import sys; sys.stdin.read(); print('{}'); sys.exit(3)"
FIRST_THEN_CRASHES = """
import json, os, sys
names = [one["name"] for one in json.load(sys.stdin)["candidates"]]
if len(names) == 2:
    print(json.dumps({"encoder": names[0], "ms": {"a": 1.0}}), flush=True)
    os.kill(os.getpid(), 9)
"""


@pytest.mark.system
@pytest.mark.parametrize(
    ("program", "limit_s", "why"),
    [
        (HANGS, 0.5, "its trial did not end in time"),
        (CRASHES, 30.0, "its trial ended early (signal 11)"),
        (LEAVES, 30.0, "its trial ended early (status 3)"),
    ],
)
def test_a_driver_that_hangs_or_crashes_is_a_reason(program: str, limit_s: float, why: str) -> None:
    """Whatever happens to the process, the server gets a result well within a minute."""
    (trial,) = try_all([GOOD], BOTH, limit_s=limit_s, command=["-c", program])
    assert trial.problem == why


@pytest.mark.system
def test_what_was_tried_before_a_crash_counts() -> None:
    """A trial before a crash counts, and the crash is attributed to its own encoder."""
    other = Hardware("mpeg4", "yuv420p")
    first, second = try_all([GOOD, other], BOTH, command=["-c", FIRST_THEN_CRASHES])
    assert first.ms == {"a": 1.0}
    assert second.problem == "its trial ended early (signal 9)"


@pytest.mark.system
def test_all_that_hang_take_no_longer_together() -> None:
    """However many hang, a start waits for at most two limits."""
    many = [Hardware(name, "yuv420p") for name in ("libx264", "mpeg4", "mjpeg", "ffv1")]
    found = try_all(many, BOTH, limit_s=0.5, command=["-c", HANGS])
    assert [one.problem for one in found][-1] == "it was not tried in time"


def test_a_process_that_cannot_be_started_is_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    """If Python cannot be started, there is no hardware, and a reason."""
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    (trial,) = try_all([GOOD], BOTH)
    assert trial.problem is not None
    assert "could not be started" in trial.problem
