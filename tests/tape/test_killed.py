"""A server that is killed while it records: all but the last second can be played."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

import av
import pytest

from wax.tape.mended import mended
from wax.tape.reading import read_events
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from wax.tape.media_file import Codec

ROOT: Final = Path(__file__).parents[2]
LOST_S: Final = 1.0


def _kill_while_filming(folder: Path, codec: Codec, after_s: float) -> float:
    """Kill it so long after its first picture; return how much it had captured by then, in s."""
    command = [sys.executable, "-m", "tests.tape.filming", str(folder), codec]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as filming:
        assert filming.stdout is not None
        assert filming.stdout.readline()
        time.sleep(after_s)
        filming.kill()
        lines = filming.stdout.read().splitlines()
    return float(lines[-1]) if lines else 0.0


def _ends_s(path: Path) -> dict[str, float]:
    """Return when the last frame of each stream that can be decoded begins."""
    ends = {}
    for stream in ("video", "audio"):
        with av.open(str(path)) as media:
            frames = media.decode(video=0) if stream == "video" else media.decode(audio=0)
            for frame in frames:
                ends[stream] = frame.time or 0.0
    return ends


def _check(folder: Path, captured_s: float) -> None:
    (part,) = Shelf(folder).parts()
    assert part.media is not None
    assert part.events is not None
    copies = folder / "copies"
    copies.mkdir()
    for path in (part.media, mended(part.media, copies)):
        ends = _ends_s(path)
        assert ends["video"] >= captured_s - LOST_S
        assert ends["audio"] >= captured_s - LOST_S
    read = read_events(part.events)
    assert read.length_ms / 1000 >= captured_s - LOST_S


@pytest.mark.system
@pytest.mark.timeout(60)
@pytest.mark.parametrize("codec", ["vp8", "h264"])
def test_a_kill_costs_a_second(codec: Codec, tmp_path: Path) -> None:
    """At any moment of the recording, by any codec."""
    captured_s = _kill_while_filming(tmp_path, codec, random.uniform(2.0, 4.0))
    assert captured_s >= 1.5
    _check(tmp_path, captured_s)


@pytest.mark.system
@pytest.mark.full
@pytest.mark.timeout(600)
def test_fifty_kills_cost_a_second_each(tmp_path: Path) -> None:
    """The same at fifty random moments."""
    for number in range(50):
        folder = tmp_path / str(number)
        codec: Codec = "h264" if number % 5 == 0 else "vp8"
        captured_s = _kill_while_filming(folder, codec, random.uniform(1.5, 6.0))
        _check(folder, captured_s)
