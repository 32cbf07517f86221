"""The sketch as it is flashed: built for an Uno, with a host's settings."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest
from tests.firmware.core import FIRMWARE, ROOT

if TYPE_CHECKING:
    from pathlib import Path

IS_WANTED = bool(os.environ.get("CI")) and sys.platform == "linux"
NO_SERVOS = "SERVO_PINS[wax::AXES] = {NONE, NONE, NONE, NONE}"


def built(
    source: Path | None = None, folder: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Build the sketch, or skip the test if the compiler was not asked for."""
    if shutil.which("avr-g++") is None and not IS_WANTED:
        pytest.skip("there is no compiler for the Arduino: sh .make/firmware.sh avr")
    where = [] if source is None else [str(source), str(folder)]
    return subprocess.run(
        ["sh", ".make/firmware.sh", "avr", *where],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )


def changed(folder: Path, *changes: tuple[str, str]) -> subprocess.CompletedProcess[str]:
    """Build the sketch with some settings changed, as a host does."""
    source = folder / "firmware"
    shutil.copytree(FIRMWARE, source)
    config = source / "wax" / "config.h"
    text = config.read_text(encoding="utf-8")
    for before, after in changes:
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    config.write_text(text, encoding="utf-8")
    return built(source, folder / "built")
