"""A machine with nothing but a loopback interface."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from e2e.harness.chromium import find_chromium
from e2e.harness.missing import missing

ROOT = Path(__file__).parents[1]


def unshare() -> list[str]:
    """Return the command that runs another one without a network, where that is permitted."""
    if shutil.which("unshare") is None:
        missing("no unshare found: install util-linux; network namespaces exist on Linux only")
    command = ["unshare", "--net"] if os.geteuid() == 0 else ["unshare", "--net", "--map-root-user"]
    if subprocess.run([*command, "true"], capture_output=True, check=False).returncode != 0:
        missing("no network namespace may be made here: run as root, or permit user namespaces")
    return command


@pytest.mark.timeout(90)
def test_picture_plays_without_any_network(tmp_path: Path) -> None:
    """Server and browser find each other on a machine that has only its loopback interface."""
    find_chromium()
    command = [*unshare(), sys.executable, "-m", "e2e.harness.alone", str(tmp_path)]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=80, check=False
    )
    log = tmp_path / "server.log"
    assert done.returncode == 0, done.stderr + (log.read_text() if log.exists() else "")
    assert int(done.stdout) >= 27
