"""The command: it prints every verdict, as text or JSON, and exits with the worst."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from wax.__main__ import main
from wax.commands.doctor import machine

if TYPE_CHECKING:
    from pathlib import Path

CHECKS = [
    "configuration",
    "TCP port",
    "UDP port",
    "addresses",
    "public address",
    "firewall",
    "certificate",
    "files",
    "picture size",
    "camera",
    "microphone",
    "serial port",
    "clock",
    "encoder",
    "processor",
    "disk",
    "UDP buffer",
    "open files",
    "threads",
]


WHOLE = pytest.mark.system
"""All checks together take two seconds: one of encoding, the rest for devices."""


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))


def _levels(printed: str) -> dict[str, str]:
    return {one["check"]: one["level"] for one in json.loads(printed)}


@WHOLE
def test_each_check_is_told_in_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A bad verdict makes the status 1, and all other checks still run."""
    path = tmp_path / "wax.toml"
    path.write_text(
        '[server]\nport = 18432\n[video]\nsource = "camera:/dev/none"\n[audio]\nsource = "none"\n'
        f'[robot]\ndriver = "serial"\n[robot.serial]\nurl = "{tmp_path}/none"\n'
    )
    assert main(["--config", str(path), "doctor", "--json"]) == 1
    levels = _levels(capsys.readouterr().out)
    assert list(levels) == CHECKS
    assert (levels["configuration"], levels["disk"]) == ("ok", "ok")
    assert (levels["camera"], levels["serial port"]) == ("bad", "bad")


@WHOLE
def test_a_wrong_configuration_is_one_of_the_verdicts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A wrong configuration is a verdict with all its problems, and the other checks run."""
    path = tmp_path / "wax.toml"
    path.write_text("[turns]\nturn_s = -1\nturns = 3\n")
    assert main(["doctor", "--config", str(path)]) == 1
    told = capsys.readouterr().out
    assert told.startswith("bad      configuration")
    assert "turns.turn_s" in told
    assert "turns.turns" in told
    assert all(f" {name} " in told for name in CHECKS)


@WHOLE
def test_a_check_that_fails_ends_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A check that raises becomes a bad verdict, with status 1."""

    def fail() -> None:
        raise RuntimeError("bug")

    monkeypatch.setattr(machine, "clock", fail)
    assert main(["doctor", "--json"]) == 1
    levels = _levels(capsys.readouterr().out)
    assert (levels["clock"], levels["disk"]) == ("bad", "ok")


@pytest.mark.parametrize("url", ["http://", "https://[", "ftp://robot.example.org", "http://a:x"])
def test_a_wrong_address_is_a_sentence(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    """`--reach` without a page's URL is a sentence, with status 2."""
    assert main(["doctor", "--reach", url]) == 2
    assert "--reach" in capsys.readouterr().err


@WHOLE
def test_its_reader_may_have_seen_enough() -> None:
    """A closed pipe, as by `head`, ends the command silently with a failure status."""
    command = [sys.executable, "-m", "wax", "doctor"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 128 + signal.SIGPIPE
