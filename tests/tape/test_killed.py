"""All but the last second of a killed server's recording can be played."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Final

import av
import pytest
from mcap.reader import make_reader
from tests.tape.filming import CAMERA_LATER_S

from wax.protocol.tape_events import Filmed
from wax.tape.reading import read_events
from wax.tape.repair import Mended, repair
from wax.tape.repaired import repaired
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from wax.tape.tape_file import Codec

ROOT: Final = Path(__file__).parents[2]
LOST_S: Final = 1.0
_AT_ONCE: Final = 4


def _kill_while_filming(folder: Path, codec: Codec, after_s: float) -> float:
    """Kill it this long after its first picture; return the time captured by then, in s."""
    command = [sys.executable, "-m", "tests.tape.filming", str(folder), codec]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as filming:
        assert filming.stdout is not None
        assert filming.stdout.readline()
        time.sleep(after_s)
        filming.kill()
        lines = filming.stdout.read().splitlines()
    assert lines, "it has not filmed"
    return float(lines[-1])


def _ends_s(path: Path, *streams: str) -> dict[str, float]:
    """Return the start of each stream's last decodable frame."""
    ends = {}
    for stream in streams:
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
    for path in (part.media, repaired(part.media, copies)):
        ends = _ends_s(path, "video", "audio")
        assert ends["video"] >= captured_s - LOST_S
        assert ends["audio"] >= captured_s - LOST_S
    camera = part.cameras[1]
    for path in (camera, repaired(camera, copies)):
        assert _ends_s(path, "video")["video"] >= captured_s - CAMERA_LATER_S - LOST_S
    read = read_events(part.events)
    (filmed,) = (one for one in read.events if isinstance(one.event, Filmed))
    assert filmed.at_ms / 1000 == pytest.approx(CAMERA_LATER_S, abs=0.001)
    assert read.length_ms / 1000 >= captured_s - LOST_S
    assert repair(Shelf(folder)) == Mended([part.name])
    for path in (part.media, camera):
        assert _ends_s(path, "video")["video"] >= captured_s - CAMERA_LATER_S - LOST_S
    with part.events.open("rb") as file:
        assert len(list(make_reader(file).iter_messages())) == len(read.events)


def _kill_and_check(folder: Path, codec: Codec) -> None:
    _check(folder, _kill_while_filming(folder, codec, random.uniform(1.5, 6.0)))


@pytest.mark.system
@pytest.mark.parametrize(
    "kills", [2, pytest.param(50, marks=[pytest.mark.full, pytest.mark.timeout(300)])]
)
def test_a_kill_costs_a_second(tmp_path: Path, kills: int) -> None:
    """A kill at any time costs at most a second, with any codec; several run at once."""
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        killed = [
            pool.submit(
                _kill_and_check, tmp_path / str(number), "h264" if number % 4 == 0 else "vp8"
            )
            for number in range(kills)
        ]
        for one in killed:
            one.result()
