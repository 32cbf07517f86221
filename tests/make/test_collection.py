"""The tests have the same names everywhere: if two workers collect different ones, the run ends."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import zip_longest
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
_PYTEST = "import gc, sys; gc.disable(); import pytest; sys.exit(pytest.main(sys.argv[1:]))"
"""Without garbage collection and assertion rewriting, collecting takes two thirds of the time."""


def _collected(*options: str, **environment: str) -> list[str]:
    done = subprocess.run(
        [
            *(sys.executable, "-c", _PYTEST, "--collect-only", "-q", "tests", "e2e"),
            *("--assert=plain", "-p", "no:cacheprovider", "-p", "no:xdist", *options),
        ],
        cwd=ROOT,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return [line for line in done.stdout.splitlines() if "::" in line]


@pytest.mark.system
@pytest.mark.full  # xdist's workers, which hash differently, compare theirs in each run
@pytest.mark.timeout(180)
def test_the_names_of_tests_are_the_same_everywhere() -> None:
    """Time, date, zone, locale, the order of hashes and of folders change no name."""
    with ThreadPoolExecutor(2) as beside:
        here = beside.submit(_collected, PYTHONHASHSEED="1", TZ="Etc/GMT+12", LC_ALL="C.UTF-8")
        # 26 hours ahead, so that the date differs at any time.
        there = {"PYTHONHASHSEED": "2", "TZ": "Pacific/Kiritimati", "LC_ALL": "C"}
        elsewhere = beside.submit(_collected, "-p", "tests.another_machine", **there)
    assert len(here.result()) > 1000
    pairs = zip_longest(here.result(), elsewhere.result())
    assert [pair for pair in pairs if len(set(pair)) > 1][:3] == []
