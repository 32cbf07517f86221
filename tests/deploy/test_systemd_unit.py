"""The systemd unit: it is valid, sandboxed, and matches the server's behaviour."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from configparser import ConfigParser
from pathlib import Path

import pytest
from tests.deploy.running import STOP_WITHIN_S

from wax.machine.priority import NICENESS, REALTIME

UNIT = Path(__file__).parents[2] / "config" / "deploy" / "wax.service"

MOST_EXPOSED: int = 20
"""Tenths of systemd's exposure level: 0 is a service that can do nothing, 96 one without limits.
What is left is for devices, the network and its own name in /etc."""


@pytest.fixture
def unit(tmp_path: Path) -> Path:
    """Replace the unit's program by one that exists here; change no other line."""
    if shutil.which("systemd-analyze") is None:
        pytest.skip("there is no systemd-analyze")
    installed = "/opt/wax/bin/wax "
    text = UNIT.read_text(encoding="utf-8")
    assert text.count(f"ExecStart={installed}") == 1
    made = tmp_path / "wax.service"
    made.write_text(text.replace(installed, f"{Path(sys.executable).with_name('wax')} "))
    return made


def _analyze(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = ["systemd-analyze", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=30)


@pytest.mark.system
def test_systemd_takes_every_line(unit: Path) -> None:
    """There is no unknown key, no wrong value, no missing program."""
    verified = _analyze("verify", "--man=no", unit)
    about_ours = [line for line in verified.stderr.splitlines() if "wax" in line]
    assert (verified.returncode, about_ours) == (0, [])


@pytest.mark.system
def test_systemd_takes_every_line_that_waits_for_its_use(unit: Path) -> None:
    """The commented lines are valid when uncommented."""
    text = re.sub(r"^#(?=\w+=)", "", unit.read_text(encoding="utf-8"), flags=re.MULTILINE)
    unit.write_text(text, encoding="utf-8")
    test_systemd_takes_every_line(unit)


def test_each_secret_of_the_manual_has_its_line() -> None:
    """The service's user may not read files of root's."""
    config = UNIT.parents[1]
    manual = "".join(
        path.read_text(encoding="utf-8")
        for path in (config / "README.md", UNIT.parent / "README.md")
    )
    named = set(re.findall(r"(?:secret|password)_file = \"(/etc/wax/([\w.-]+))\"", manual))
    assert named
    unit = UNIT.read_text(encoding="utf-8")
    for path, name in named:
        assert f"\n#LoadCredential={name}:{path}\n" in unit


@pytest.mark.system
def test_it_can_do_little_beside_its_work(unit: Path) -> None:
    """Its exposure is in systemd's lowest class but one; a line that increases it is noticed."""
    rated = _analyze("security", "--offline=true", f"--threshold={MOST_EXPOSED}", unit)
    if "unrecognized option" in rated.stderr:
        pytest.skip("this systemd-analyze rates no files")
    assert rated.returncode == 0, rated.stdout


def test_it_agrees_with_the_server() -> None:
    """It waits for READY, allows enough time to end, and does not restart a wrong configuration."""
    parser = ConfigParser(strict=False, interpolation=None)
    parser.optionxform = str  # type: ignore[assignment,method-assign]  # the documented way
    parser.read(UNIT, encoding="utf-8")
    service = parser["Service"]
    assert service["Type"] == "notify"
    assert float(service["TimeoutStopSec"]) >= 3 * STOP_WITHIN_S
    assert float(service["WatchdogSec"]) >= 5.0  # a busy start of many peers is no hang
    assert service["RestartPreventExitStatus"] == "2"
    assert service["LimitRTPRIO"] == str(REALTIME)
    assert service["LimitNICE"] == str(NICENESS)
    assert "RestrictRealtime" not in service
    assert service["SystemCallFilter"] == "sched_setscheduler setpriority"  # the last of them
    assert service["KillMode"] == "mixed"  # the driver's process ends when the server says so
