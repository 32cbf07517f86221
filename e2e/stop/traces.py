"""Generated traces in great number: the property tests of the untrusted channel at full length."""

from __future__ import annotations

import asyncio
import os
import sys
from typing import Final

from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, counted
from e2e.measure.suite import ROOT

_TESTS: Final = {
    "codec, gate and latch": "tests/control/test_black_channel.py",
    "turns and hand-overs": "tests/control/test_hand_over.py",
    "a person aboard": "tests/robot/process/test_hand_black_channel.py",
    "firmware": "tests/firmware/test_line_black_channel.py::test_no_wrong_execution",
}
_FAILED: Final = 1
"""pytest's exit status when a test has failed."""


async def traces(n: int) -> list[Row]:
    """Run each for `n` traces; a failing test counts once, because it ends there."""
    return [await _traces(what, test, n) for what, test in _TESTS.items()]


async def _traces(what: str, test: str, n: int) -> Row:
    environment = os.environ | {"WAX_TRACES": str(n), "WAX_STEPS": str(n)}
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "pytest", "-q", "--timeout=0", test),
        cwd=ROOT,
        env=environment,
        stdout=sys.stderr,
    )
    code = await process.wait()
    if code not in (0, _FAILED):
        raise MeasureError(f"{test}: pytest ended with {code}")
    return counted(f"traces: {what}", f"wrong executions of generated traces: {what}", code, n)
