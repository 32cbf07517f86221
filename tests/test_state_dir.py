"""The state folder, for files that outlive the server."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from wax import state_dir
from wax.errors import StateError

if TYPE_CHECKING:
    from collections.abc import Callable


@pytest.mark.parametrize(
    ("configured", "environment", "found"),
    [
        ("/srv/wax", {"STATE_DIRECTORY": "/var/lib/wax"}, "/srv/wax"),
        ("", {"STATE_DIRECTORY": "/var/lib/wax:/other", "XDG_STATE_HOME": "/x"}, "/var/lib/wax"),
        ("", {"XDG_STATE_HOME": "/x"}, "/x/wax"),
        ("", {"XDG_STATE_HOME": "relative"}, "~/.local/state/wax"),
        ("", {}, "~/.local/state/wax"),
        ("~/robot", {}, "~/robot"),
    ],
)
def test_where_it_is(configured: str, environment: dict[str, str], found: str) -> None:
    """The folder is the configured one, else systemd's, else the user's."""
    assert state_dir.find(configured, environment) == Path(found).expanduser()


def test_without_a_home_it_must_be_configured(monkeypatch: pytest.MonkeyPatch) -> None:
    """A user without a home directory, as in a container, is told which key to set."""
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setattr("os.getuid", lambda: 2**31 - 5)  # a user who is not in passwd
    for configured in ("", "~/robot"):
        with pytest.raises(StateError, match="state_dir"):
            state_dir.find(configured, {})


def test_it_is_made_for_its_user_only(tmp_path: Path) -> None:
    """A new folder and its files are closed to others; an existing folder keeps its mode."""
    made = state_dir.prepare(tmp_path / "new" / "wax")
    assert made.stat().st_mode & 0o777 == 0o700
    state_dir.make_private(made / "secret")
    assert (made / "secret").stat().st_mode & 0o777 == 0o600
    (made / "open").touch(0o644)
    state_dir.make_private(made / "open")
    assert (made / "open").stat().st_mode & 0o777 == 0o600
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o755)
    state_dir.prepare(shared)
    assert shared.stat().st_mode & 0o777 == 0o755


def test_what_is_no_file_keeps_its_mode(tmp_path: Path) -> None:
    """A device in place of a file keeps its mode, which root could change for everybody."""
    pipe = tmp_path / "null"
    os.mkfifo(pipe)
    pipe.chmod(0o666)
    with pytest.raises(OSError, match="it is a pipe"):
        state_dir.make_private(pipe)
    assert pipe.stat().st_mode & 0o777 == 0o666


def test_a_folder_that_cannot_be_is_a_sentence(tmp_path: Path) -> None:
    """The sentence names the folder and the key to set."""
    (tmp_path / "file").write_text("")
    with pytest.raises(StateError, match=r"file.*state_dir"):
        state_dir.prepare(tmp_path / "file" / "wax")


@pytest.mark.parametrize("fails", ["write", "fsync", "replace"])
def test_a_file_is_replaced_as_a_whole(
    fails: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A failed replacement leaves the old file; the new one is on disk before the rename."""
    path = tmp_path / "kept.json"
    state_dir.replace(path, b"old")
    acts: list[str] = []

    def act(name: str, then: Callable[..., object]) -> Callable[..., object]:
        def done(*given: object) -> object:
            acts.append(name)
            if name == fails:
                raise OSError(errno.EIO, "it breaks")
            return then(*given)

        return done

    monkeypatch.setattr(os, "fdopen", act("write", os.fdopen))
    monkeypatch.setattr(os, "fsync", act("fsync", os.fsync))
    monkeypatch.setattr(Path, "replace", act("replace", Path.replace))
    with pytest.raises(OSError, match="it breaks"):
        state_dir.replace(path, b"new")
    assert path.read_bytes() == b"old"
    assert acts == ["write", "fsync", "replace"][: len(acts)]
    fails = ""
    state_dir.replace(path, b"new")
    assert path.read_bytes() == b"new"
    assert acts[-4:] == ["write", "fsync", "replace", "fsync"]
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_file_that_somebody_has_is_no_one_elses(tmp_path: Path) -> None:
    """A lock excludes others until the file is closed; shared locks coexist."""
    path = tmp_path / "locked"
    path.touch()
    with path.open("rb") as first, path.open("rb") as second:
        state_dir.lock(first, shared=True)
        state_dir.lock(second, shared=True)
        with pytest.raises(BlockingIOError):
            state_dir.lock(first)
        second.close()
        state_dir.lock(first)
        with path.open("rb") as third, pytest.raises(BlockingIOError):
            state_dir.lock(third, shared=True)
