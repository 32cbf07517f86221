"""The sketch for the Arduino, compiled by the compiler that its owner's is."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import pytest
from tests.firmware.core import ROOT

pytestmark = pytest.mark.system


@pytest.mark.timeout(300)
def test_the_sketch_fits_an_uno() -> None:
    """It compiles for the ATmega328P without a warning, in half of its memory at most."""
    wanted = bool(os.environ.get("CI")) and sys.platform == "linux"
    if shutil.which("avr-g++") is None and not wanted:
        pytest.skip("there is no compiler for the Arduino: sh .make/firmware.sh avr")
    built = subprocess.run(
        ["sh", ".make/firmware.sh", "avr"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stderr
    sizes = json.loads(built.stdout)
    assert 4000 < sizes["flash_bytes"] < sizes["flash_bytes_of"] // 2
    assert 100 < sizes["ram_bytes"] < sizes["ram_bytes_of"] // 2
