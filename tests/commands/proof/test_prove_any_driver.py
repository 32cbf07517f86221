"""`wax prove-stop` from start to end, with foreign drivers."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Final

import pytest
from tests.commands.proof.robots import LEFT

from wax.session.proof_runner import NOT_ALL

pytestmark = [pytest.mark.system, pytest.mark.full, pytest.mark.timeout(240)]

ROOT: Final = Path(__file__).parents[3]
MEASURED: Final = 6


def begin(folder: Path, name: str, base: str = "differential") -> subprocess.Popen[str]:
    (folder / "wax.toml").write_text(
        f'[robot]\ndriver = "tests.commands.proof.robots:{name}"\nbase = "{base}"\n'
    )
    command = [sys.executable, "-m", "wax", "--config", "wax.toml", "prove-stop", "--lifted"]
    command += ["--repeats", "1", "--record", "record.html"]
    return subprocess.Popen(
        command,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT), LEFT: str(folder / "left")},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def prove(folder: Path, name: str, base: str = "differential") -> tuple[int, str, str]:
    """Run it to its end; return its status, standard output and standard error."""
    with begin(folder, name, base) as process:
        said, complaint = process.communicate()
    return process.returncode, said, complaint


@pytest.mark.alone
@pytest.mark.parametrize("name", ["Moving", "Posing"])
def test_what_can_be_cut_is_proved_and_the_rest_is_named(tmp_path: Path, name: str) -> None:
    """A robot that stops in time passes for the links cut; the status says that some were not."""
    status, said, complaint = prove(tmp_path, name)
    record = (tmp_path / "record.html").read_text(encoding="utf-8")
    assert status == NOT_ALL, f"{said}\n{complaint}"
    assert record.count("<td>passed</td>") == MEASURED
    assert record.count("<td>not proved</td>") == 2
    last = said.splitlines()[-1]
    assert last.startswith("Each measurable link was cut once; the robot stood within ")
    assert last.endswith("Not proved: The driver process is killed; The link to the robot is cut.")
    assert "the call of the driver" in record
    assert f"Driver tests.commands.proof.robots:{name}" in record
    assert not complaint


@pytest.mark.alone
def test_each_stop_is_also_proved_sideways(tmp_path: Path) -> None:
    """A robot that moves sideways is cut off as often while it does."""
    status, said, complaint = prove(tmp_path, "Sliding", "mecanum")
    assert status == NOT_ALL, f"{said}\n{complaint}"
    assert said.splitlines()[-1].startswith("Each measurable link was cut 2 times; ")
    record = (tmp_path / "record.html").read_text(encoding="utf-8")
    assert record.count("<td>passed</td>") == MEASURED
    assert "slid" in (tmp_path / "left").read_text(encoding="utf-8")


def test_a_robot_that_rolls_on_is_not_proved(tmp_path: Path) -> None:
    """A robot that is stopped in time but reports that it rolls on fails."""
    status, said, complaint = prove(tmp_path, "Late")
    record = (tmp_path / "record.html").read_text(encoding="utf-8")
    assert status == 1, f"{said}\n{complaint}"
    assert record.count("<td>FAILED</td>") == MEASURED
    assert "Not proved: too late, or no stop at all: " in said


def test_a_robot_that_reports_no_motion_is_refused(tmp_path: Path) -> None:
    """A robot that reports no motion is refused in one line, without motion or a record."""
    status, said, complaint = prove(tmp_path, "Blind")
    assert status == 2, f"{said}\n{complaint}"
    assert complaint.count("\n") == 1
    assert "neither moving nor pose" in complaint
    assert not (tmp_path / "record.html").exists()


def test_a_robot_that_is_not_there_is_named(tmp_path: Path) -> None:
    """An unreachable robot is reported with its driver's own sentence."""
    status, said, complaint = prove(tmp_path, "Absent")
    assert status == 1, f"{said}\n{complaint}"
    assert "the robot is not connected. The robot cannot be reached (no route to it)" in complaint


def test_broken_off_it_leaves_a_robot_that_stands(tmp_path: Path) -> None:
    """A signal while driving stops the robot before its driver releases it."""
    with begin(tmp_path, "Moving") as process:
        assert process.stdout is not None
        for line in process.stdout:
            if "vanishes" in line:
                break
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        said, complaint = process.communicate()
    assert process.returncode == 1, f"{said}\n{complaint}"
    assert "Not proved: it was aborted." in said
    assert (tmp_path / "left").read_text(encoding="utf-8") == "standing\n"
