"""The instrument under its own magnifying glass: what it is trusted for is shown, not said."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from e2e.harness.chromium import NAMES
from e2e.harness.missing import missing
from e2e.lab.instrument.cards import LIE_MS, LyingClock, lies
from e2e.lab.instrument.error import judge, own_error
from e2e.lab.instrument.judge import shift
from e2e.lab.instrument.synthetic import readings

ROOT = Path(__file__).parents[3]
OWNER = """
import asyncio, sys
from pathlib import Path
from e2e.lab.instrument.error import _server

async def main():
    async with _server(Path(sys.argv[1])) as url:
        print(url, flush=True)
        await asyncio.sleep(60)

asyncio.run(main())
"""


def test_the_clock_lies_in_every_other_second_only() -> None:
    """Its wall clock is honest, then 100 ms behind, changing at half seconds; the other is true."""

    class At:
        def __init__(self, wall_ms: int) -> None:
            self._wall_ms = wall_ms

        def now_s(self) -> float:
            return 7.0

        def wall_ms(self) -> int:
            return self._wall_ms

    told = [LyingClock(At(wall_ms)).wall_ms() for wall_ms in (400, 500, 1499, 1500)]
    assert told == [400, 400, 1399, 1500]
    assert LyingClock(At(500)).now_s() == 7.0


@pytest.mark.parametrize("wrong_ms", [0.0, -8.0, 30.0])
def test_a_shift_that_is_read_wrong_is_told(wrong_ms: float) -> None:
    """What an instrument makes of the lie comes out as it is, also while all ages drift."""
    stamps = [10_000_000.0 + 33 * n for n in range(600)]
    read = [
        (stamp, 80 + n / 20 + ((LIE_MS + wrong_ms) if lies(stamp) else 0))
        for n, stamp in enumerate(stamps)
    ]
    found = shift(read)
    assert found is not None
    assert found.ms == pytest.approx(LIE_MS + wrong_ms, abs=0.5)
    assert found.uncertain_ms < 0.5


def test_an_instrument_that_reads_wrong_is_not_ok() -> None:
    """A source that lies by 90 instead of 100, two that are 6 ms apart, nothing heard: not ok."""
    right = readings(20, lie_ms=100)
    found, certain = judge(right, right)
    assert (found["ok"], certain) == (True, True)
    assert not judge(readings(20, lie_ms=90), readings(20, lie_ms=90))[0]["ok"]
    assert not judge(right, readings(20, lie_ms=100, picture_age_ms=86))[0]["ok"]
    assert not judge(right, readings(20, lie_ms=100, sound_age_ms=126))[0]["ok"]
    silent, certain = judge(readings(20, lie_ms=100, sound=False), right)
    assert (silent["ok"], certain) == (False, False)


def test_a_crash_leaves_no_server(tmp_path: Path) -> None:
    """When who measures is killed, the server that it started ends too."""

    def serves(port: int) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    arguments = [sys.executable, "-c", OWNER, str(tmp_path)]
    with subprocess.Popen(arguments, cwd=ROOT, stdout=subprocess.PIPE, text=True) as owner:
        assert owner.stdout is not None
        port = urlsplit(owner.stdout.readline().strip()).port
        try:
            assert port is not None
            assert serves(port)
        finally:
            owner.kill()
    until_s = time.monotonic() + 12
    while serves(port):
        assert time.monotonic() < until_s, "the server is still there"
        time.sleep(0.05)


def test_a_tethered_program_may_end_by_itself() -> None:
    """Its exit status is told while the pipe is still open."""
    tether = [sys.executable, "-m", "e2e.lab.instrument.tether", "sh", "-c", "exit 7"]
    with subprocess.Popen(tether, cwd=ROOT, stdin=subprocess.PIPE) as process:
        assert process.wait(10) == 7


@pytest.mark.timeout(150)
async def test_two_agree_and_a_lie_is_read() -> None:
    """In Chromium two on one page agree within 5 ms, and +100 ms in the source is read as such."""
    if not (os.environ.get("WAX_CHROMIUM") or any(map(shutil.which, NAMES))):
        missing("no Chromium found: install the package chromium, or set WAX_CHROMIUM to its path")
    found = await own_error()
    assert found["ok"], found
