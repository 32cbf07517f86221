"""A machine with nothing but a loopback interface."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from e2e.harness.installed import CHROMIUM, installed
from e2e.link import namespace
from e2e.measure.errors import NotRunError
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from pathlib import Path


def alone() -> list[str]:
    """Return the command that runs another one with a loopback alone; raises `NotRunError`."""
    unshare = [namespace.tool("unshare", "util-linux"), "--net"]
    command = unshare if os.geteuid() == 0 else [*unshare, "--map-root-user"]
    if subprocess.run([*command, "true"], capture_output=True, check=False).returncode != 0:
        raise NotRunError("no network namespace may be made; be root, or permit user namespaces")
    up = f'{namespace.tool("ip", "iproute2")} link set lo up && exec "$@"'
    return [*command, "sh", "-c", up, "sh"]


@pytest.mark.timeout(90)
def test_picture_plays_without_any_network(tmp_path: Path) -> None:
    """Server and browser find each other on a machine that has only its loopback interface."""
    installed(*CHROMIUM)
    command = [*alone(), sys.executable, "-m", "e2e.harness.alone", str(tmp_path)]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=80, check=False
    )
    log = tmp_path / "server.log"
    assert done.returncode == 0, done.stderr + (log.read_text() if log.exists() else "")
    assert int(done.stdout) >= 27
