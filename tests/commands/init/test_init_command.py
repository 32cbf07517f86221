"""`wax init` at a terminal: it writes one whole file, or nothing."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest

from wax.__main__ import main
from wax.commands.init.command import init
from wax.commands.init.found import Found, Thing
from wax.config import settings as config
from wax.errors import ConfigError, StateError

if TYPE_CHECKING:
    from pathlib import Path

BENCH = Found(cameras=(Thing("/dev/video0", "Front"), Thing("/dev/video2", "Rear")))


def no_detect() -> Found:
    raise AssertionError("it looked, though nothing can be written")


def test_a_person_is_asked_until_the_answer_is_one(tmp_path: Path) -> None:
    """A question is repeated until the answer is valid; Enter is the first choice."""
    path = tmp_path / "robot.toml"
    replies = iter(["", "9", "no", "3", "", "", "2"])
    told: list[str] = []
    init(path, ask=lambda _: next(replies), tell=told.append, detect=lambda: BENCH)
    settings = config.load(path)
    assert settings.robot.driver == "simulated"
    assert settings.video.source == "/dev/video2"
    assert settings.server.https
    assert sum("Type a number from 1 to" in line for line in told) == 2
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("how", ["file", "link", "folder"])
def test_nothing_is_overwritten(tmp_path: Path, how: str) -> None:
    """An existing file is left alone, and nothing is asked."""
    path = tmp_path / "robot.toml"
    if how == "file":
        path.write_text("mine")
    elif how == "link":
        path.symlink_to(tmp_path / "nowhere")
    else:
        path.mkdir()
    with pytest.raises(ConfigError, match="is there already"):
        init(path, ask=None, tell=print, detect=no_detect)
    assert how != "file" or path.read_text() == "mine"


def test_a_file_made_meanwhile_stays(tmp_path: Path) -> None:
    """A file that appears during the questions is not replaced either."""
    path = tmp_path / "robot.toml"

    def ask(_: str) -> str:
        path.write_text("mine")
        return ""

    with pytest.raises(ConfigError, match="meanwhile"):
        init(path, ask=ask, tell=print, detect=lambda: BENCH)
    assert path.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_is_not_there_is_a_sentence(tmp_path: Path) -> None:
    """A missing folder is reported before anything is asked."""
    with pytest.raises(ConfigError, match="is no folder; make it first"):
        init(tmp_path / "none" / "robot.toml", ask=None, tell=print, detect=no_detect)


def test_a_full_disk_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A full disk leaves no partial file."""

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StateError, match="No space left"):
        init(tmp_path / "robot.toml", ask=None, tell=print, detect=lambda: BENCH)
    assert list(tmp_path.iterdir()) == []


def test_what_would_not_start_is_not_written(tmp_path: Path) -> None:
    """A configuration whose driver cannot be built is reported and not written."""
    with pytest.raises(ConfigError, match="got 'broken'"):
        init(
            tmp_path / "robot.toml",
            ask=lambda _: "2",
            tell=print,
            detect=lambda: Found(drivers=("broken",)),
        )
    assert list(tmp_path.iterdir()) == []


def test_without_a_terminal_it_takes_yes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a terminal, `wax init` asks for --yes, which asks nothing."""
    path = tmp_path / "robot.toml"
    with open(os.devnull) as nothing:  # noqa: PTH123
        monkeypatch.setattr(sys, "stdin", nothing)
        assert main(["init", str(path)]) == 2
        assert "--yes" in capsys.readouterr().err
        assert not path.exists()
        assert main(["init", "--yes", "--serial", "/dev/ttyACM7", str(path)]) == 0
    assert "is written" in capsys.readouterr().out
    settings = config.load(path)
    assert (settings.robot.driver, settings.robot.serial.url) == ("serial", "/dev/ttyACM7")


@pytest.mark.system
@pytest.mark.parametrize("how", ["Ctrl-C", "Ctrl-D"])
def test_breaking_off_leaves_nothing(tmp_path: Path, how: str) -> None:
    """Ctrl-C or Ctrl-D at a real terminal ends it without a file or a traceback."""
    ours, theirs = pty.openpty()
    # In the background a shell has it ignored, which a child would inherit.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = subprocess.Popen(
        [sys.executable, "-m", "wax", "init", "robot.toml"],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        cwd=tmp_path,
        start_new_session=True,
    )
    signal.signal(signal.SIGINT, before)
    os.close(theirs)
    try:
        said = _read_until(ours, "Enter for 1")
        time.sleep(0.5)  # a signal between the question and the reading is seen with the next key
        if how == "Ctrl-C":
            os.killpg(process.pid, signal.SIGINT)
        else:
            os.write(ours, b"\x04")
        said += _read_until(ours, "Nothing was written")
        assert process.wait(timeout=20) == 130
    finally:
        process.kill()
        process.wait()
        os.close(ours)
    assert "Traceback" not in said
    assert list(tmp_path.iterdir()) == []


def _read_until(terminal: int, words: str) -> str:
    said = ""
    end_s = time.monotonic() + 40
    while words not in said:
        ready, _, _ = select.select([terminal], [], [], end_s - time.monotonic())
        assert ready, f"it never said {words!r} but {said!r}"
        said += os.read(terminal, 4096).decode(errors="replace")
    return said
