"""The command: every wrong use is one sentence and a nonzero status."""

from __future__ import annotations

import asyncio
import io
import os
import sys
from typing import TYPE_CHECKING, Any, cast

import pytest

from wax import __version__
from wax.__main__ import main, until_read
from wax.access.host_link import HostLinkSocket

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


def test_devices_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """`wax devices` lists cameras, microphones and serial ports, even if there are none."""
    assert main(["devices"]) == 0
    listed = capsys.readouterr().out.lower()
    for what in ("camera", "microphone", "serial"):
        assert what in listed


@pytest.mark.skipif(sys.platform == "win32", reason="its event loop has no selector")
def test_the_server_serves_few_connections_in_a_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    """The server runs the event loop that strangers' connections cannot fill."""
    found: list[Any] = []

    class App:
        def __init__(self, **_: object) -> None:
            pass

        def has_people_at(self, _: str) -> bool:
            return False

        async def run(self, _: object) -> None:
            loop: Any = asyncio.get_running_loop()
            found.extend((loop._selector, loop._ready))

    monkeypatch.setattr("wax.app.App", App)
    monkeypatch.setattr("wax.__main__.configure_logs", lambda _: None)
    assert main([]) == 0
    assert [type(one).__name__ for one in found] == ["BoundedSelector", "_Ready"]


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """`wax --version` prints the package's version."""
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.strip() == f"wax {__version__}"


async def test_the_addresses_that_measure_delay_are_printed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`wax glass` prints the page that measures with a host link, and the code's without one."""
    (tmp_path / "wax.toml").write_text(f'[server]\nstate_dir = "{tmp_path}"\n')
    links = ["http://localhost:8080/#host=secret", "https://robot.example/below/#host=secret"]
    served = HostLinkSocket(str(tmp_path), lambda: links)
    await served.open()
    arguments = ["glass", "--config", str(tmp_path / "wax.toml")]
    assert await asyncio.to_thread(main, arguments) == 0
    await served.close()
    assert [line.strip() for line in capsys.readouterr().out.splitlines() if "://" in line] == [
        "http://localhost:8080/?view=glass#host=secret",
        "https://robot.example/below/?view=glass#host=secret",
        "http://localhost:8080/?view=glass&only=code",
        "https://robot.example/below/?view=glass&only=code",
    ]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--config", "nowhere.toml"], "nowhere.toml"),
        (["--port", "99999"], "server.port"),
        (["--host", ""], "server.host"),
    ],
)
def test_wrong_use_is_a_sentence(
    arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Wrong use is a sentence on standard error, with status 2."""
    assert main(arguments) == 2
    shown = capsys.readouterr()
    assert says in shown.err
    assert "Traceback" not in shown.err


@pytest.mark.parametrize("command", [(), ("run",)])
def test_all_problems_of_a_file_are_told(
    command: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A configuration with two mistakes is refused with both, named before `run` or after it."""
    path = tmp_path / "robot.toml"
    path.write_text("[turns]\nturn_s = -1\n[drive]\nwheels = 4\n")
    assert main([*command, "--config", str(path)]) == 2
    shown = capsys.readouterr().err
    assert "turns.turn_s" in shown
    assert "drive.wheels" in shown


def test_there_is_no_host_link_where_groups_decide(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`wax host-link` says who decides who is host where links are switched off."""
    path = tmp_path / "robot.toml"
    path.write_text(
        '[server]\ntrusted_proxies = ["127.0.0.1"]\n[access.proxy]\nperson = "Remote-User"\n'
        'groups = "Remote-Groups"\nhost = ["staff"]\nhost_link = false\n'
    )
    assert main(["host-link", "--config", str(path)]) == 1
    assert "decided by groups" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--lifted"], "nothing to prove"),
        (["--lifted", "--repeats", "0"], "--repeats"),
        (["--lifted", "--config", "nowhere.toml"], "nowhere.toml"),
    ],
)
def test_a_proof_that_cannot_be_made_is_a_sentence(
    arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """`wax prove-stop` refuses wrong use, and a robot that cannot be proved."""
    assert main(["prove-stop", *arguments]) == 2
    shown = capsys.readouterr()
    assert says in shown.err
    assert "Traceback" not in shown.err


@pytest.mark.parametrize("before", [True, False])
def test_no_proof_moves_a_robot_that_may_stand_on_the_floor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], *, before: bool
) -> None:
    """Without --lifted or a terminal to ask at, nothing is opened and nothing is written."""
    path = tmp_path / "robot.toml"
    path.write_text('[robot]\ndriver = "serial"\n')
    given = ["--config", str(path)]
    arguments = [*given, "prove-stop"] if before else ["prove-stop", *given]
    assert main([*arguments, "--record", str(tmp_path / "record.html")]) == 2
    assert "--lifted" in capsys.readouterr().err
    assert not (tmp_path / "record.html").exists()


def test_a_robot_that_is_not_there_cannot_be_proved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A port that cannot be opened is one sentence, status 1 and no record."""
    path = tmp_path / "robot.toml"
    path.write_text(f'[robot]\ndriver = "serial"\n[robot.serial]\nurl = "{tmp_path}/none"\n')
    record = tmp_path / "record.html"
    assert main(["prove-stop", "--config", str(path), "--lifted", "--record", str(record)]) == 1
    assert "cannot be opened" in capsys.readouterr().err
    assert not record.exists()


def test_the_tape_is_listed_and_deleted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`wax tape` uses the configured folder, or the one given as an option."""
    folder = tmp_path / "tape"
    folder.mkdir()
    (folder / "wax-20261123T140000Z.mcap").write_bytes(b"")
    config = tmp_path / "robot.toml"
    config.write_text(f'[recording]\nfolder = "{folder}"\n')
    for asked in (
        ["tape", "--config", str(config), "list"],
        ["tape", "list", "--config", str(config)],
    ):
        assert main(asked) == 0
        assert "wax-20261123T140000Z" in capsys.readouterr().out
    assert main(["tape", "--folder", str(folder), "delete"]) == 2
    assert "say what to delete" in capsys.readouterr().err
    assert main(["tape", "--folder", str(folder), "delete", "--all"]) == 0
    assert list(folder.iterdir()) == []


def test_the_tape_is_exported_in_a_form_that_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`wax tape export` needs a form, and something that is recorded."""
    with pytest.raises(SystemExit):
        main(["tape", "--folder", str(tmp_path), "export"])
    assert "--lerobot --mcap is required" in capsys.readouterr().err
    for form in ("--lerobot", "--mcap"):
        asked = ["tape", "--folder", str(tmp_path), "export", form, str(tmp_path / "out")]
        assert main([*asked, "--from", "2026-11-01"]) == 1
        assert "nothing is recorded at that time" in capsys.readouterr().err


def test_there_must_be_something_to_replay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a tape, `wax replay` prints one sentence and serves no page."""
    assert main(["replay", str(tmp_path / "gone.mcap")]) == 1
    assert "gone.mcap does not exist" in capsys.readouterr().err
    assert main(["replay", str(tmp_path)]) == 1
    assert "nothing of a tape" in capsys.readouterr().err


def test_a_terminal_that_lacks_a_sign_ends_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A character that a Latin-1 terminal lacks is printed as an escape."""
    shown = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    monkeypatch.setattr(sys, "stderr", shown)
    assert main(["--config", str(tmp_path / "робот.toml")]) == 2
    shown.seek(0)
    assert "\\u0440" in shown.read()


@pytest.fixture
def unread() -> Iterator[int]:
    """Return a pipe without a reader."""
    read, write = os.pipe()
    os.close(read)
    yield write
    os.close(write)


@pytest.mark.parametrize("is_buffered", [True, False])
@pytest.mark.parametrize("arguments", [["hook", "schema"], ["config", "simulated"]])
def test_a_reader_who_has_seen_enough_ends_it(
    arguments: list[str], unread: int, monkeypatch: pytest.MonkeyPatch, *, is_buffered: bool
) -> None:
    """A closed pipe ends any command as SIGPIPE would, without a message at exit."""
    raw = io.FileIO(unread, "wb", closefd=False)
    shown = io.TextIOWrapper(
        io.BufferedWriter(raw) if is_buffered else cast("io.BufferedWriter", raw),
        write_through=not is_buffered,
    )
    monkeypatch.setattr(sys, "stdout", shown)
    status = until_read(lambda: main(arguments))
    assert status == 141
    shown.write("the rest")
    shown.close()


def test_a_version_that_nobody_reads(unread: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A closed pipe ends `--version` as quietly."""
    with os.fdopen(os.dup(unread), "w") as shown:
        monkeypatch.setattr(sys, "stdout", shown)
        assert until_read(lambda: main(["--version"])) == 141


def test_a_complaint_that_nobody_reads_ends_it(
    unread: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A closed standard error ends the command, too."""
    with os.fdopen(os.dup(unread), "w", buffering=1) as shown:
        monkeypatch.setattr(sys, "stderr", shown)
        assert until_read(lambda: main(["--config", "nowhere.toml"])) == 141


def test_another_pipe_that_breaks_is_a_fault() -> None:
    """A `BrokenPipeError` of another pipe is raised if both our streams are read."""

    def breaks() -> int:
        raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        until_read(breaks)


def test_nothing_is_written_for_everybody_to_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No file is writable for everybody, even with a container's umask of 0."""
    monkeypatch.chdir(tmp_path)
    before = os.umask(0)
    try:
        assert main(["new-driver", "rover"]) == 0
        assert os.umask(0) == 0o002
    finally:
        os.umask(before)
    made = [*tmp_path.rglob("*")]
    assert made
    assert not [path for path in made if path.stat().st_mode & 0o002]


def test_a_closed_stream_is_an_empty_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A standard stream that a supervisor has closed acts as an empty one."""
    monkeypatch.setattr(sys, "stdin", None)
    assert main(["init"]) == 2
    assert "no terminal" in capsys.readouterr().err
    assert sys.stdin is not None
    assert sys.stdin.read() == ""
    sys.stdin.close()
