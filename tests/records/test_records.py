"""Records are in the file within a second, and trouble with the file reaches nobody."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

import pytest
import structlog
from tests.turned_clock import TurnedClock
from tests.until import until

from wax import state_dir
from wax.clock import SystemClock
from wax.config.records import RecordSettings
from wax.records import schema, writer
from wax.records.entries import Ban, HostCookie, Invited, Lasting, LinkSummary, RecordedPerson
from wax.records.file import open_for_reading, open_for_writing
from wax.records.opening import load_lasting, open_records
from wax.records.records import Records
from wax.records.writer import RecordWriter

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


OF_0_9_0 = "9e02a21df2c10046b075b62d1d1e823df8ada0d095edc0c8e3ce972c8aa3901d"
ADA = RecordedPerson("ada-11111111", "Ada")
HOST = RecordedPerson("host-1111111", "Hedy")
DAY_MS = 86_400_000


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "records.db"


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "RETRY_S", 0.05)


def opened(path: Path, **settings: Any) -> Records:
    return open_records(RecordSettings(path=str(path), **settings), "", SystemClock())


@contextmanager
def writing(path: Path, **settings: Any) -> Iterator[Records]:
    """Open records, and wait after the block until all are written or dropped."""
    records = opened(path, **settings)
    records.start()
    yield records
    records.stop(10.0)


def rows(path: Path, table: str) -> list[dict[str, Any]]:
    with closing(open_for_reading(path)) as file:
        file.row_factory = sqlite3.Row
        return [dict(row) for row in file.execute(f"SELECT * FROM {table} ORDER BY began_ms")]


def acts(path: Path) -> list[str]:
    return [row["detail"] for row in rows(path, "acts")]


def test_a_night_is_remembered(path: Path) -> None:
    """A visit with its link, a turn, a stop, an act and a refusal are a row each."""
    with writing(path) as records:
        visit = records.session_began(ADA, address="192.0.2.7", role="guest")
        turn = records.turn_began(3, ADA)
        stop = records.stop_pressed(1, ADA, "pressed")
        records.stop_released(stop, "Hedy")
        records.turn_ended(turn, "left")
        records.host_act(HOST, "remove", about="Ada", detail="banned")
        records.refused({"messages over the rate": 2})
        records.refused({"messages over the rate": 3})
        link = LinkSummary(round_trip_ms=40.0, lost_percent=0.5, rendition="640x480")
        records.session_seen(
            visit, RecordedPerson(ADA.identity, "Ada L."), "guest", link, is_over=True
        )
    (session,) = rows(path, "sessions")
    assert (session["name"], session["address"], session["role"]) == (
        "Ada L.",
        "192.0.2.0/24",
        "guest",
    )
    assert (session["round_trip_ms"], session["lost_percent"]) == (40.0, 0.5)
    assert session["began_ms"] <= session["ended_ms"] <= time.time_ns() // 1_000_000
    (turned,) = rows(path, "turns")
    assert (turned["number"], turned["why"], turned["name"]) == (3, "left", "Ada")
    (stopped,) = rows(path, "stops")
    assert (stopped["number"], stopped["reason"], stopped["released_by"]) == (1, "pressed", "Hedy")
    assert stopped["ended_ms"] is not None
    (act,) = rows(path, "acts")
    assert (act["name"], act["act"], act["about"], act["detail"]) == (
        "Hedy",
        "remove",
        "Ada",
        "banned",
    )
    (refused,) = rows(path, "refusals")
    assert (refused["reason"], refused["count"]) == ("messages over the rate", 5)


def test_files_of_0_9_0_have_these_tables() -> None:
    """The first step stays what made the files of 0.9.0: only then do later ones fit them."""
    bare = re.sub(r"--.*|\s", "", schema.STEPS[0])
    assert hashlib.sha256(bare.encode()).hexdigest() == OF_0_9_0


def test_identities_are_not_in_the_file(path: Path) -> None:
    """The file admits nobody as somebody else, and still shows which visits are one person's."""
    with writing(path) as records:
        records.session_began(ADA, address="192.0.2.7", role="guest")
        records.turn_began(1, ADA)
    assert ADA.identity.encode() not in path.read_bytes()
    assert rows(path, "sessions")[0]["person"] == rows(path, "turns")[0]["person"]


def test_only_its_user_reads_it(tmp_path: Path) -> None:
    """The folder and each file in it are private."""
    path = tmp_path / "state" / "records.db"
    with writing(path):
        beside = [path.with_name(f"records.db-{name}") for name in ("wal", "shm")]
        while not all(one.exists() for one in beside):
            time.sleep(0.01)
        found = {one.name: one.stat().st_mode & 0o777 for one in path.parent.iterdir()}
    assert path.parent.stat().st_mode & 0o777 == 0o700
    assert len(found) == 3
    assert set(found.values()) == {0o600}


def test_what_was_open_at_a_crash_is_closed(path: Path) -> None:
    """The next server ends open visits when last seen, and marks open turns as killed."""
    with writing(path) as records:
        records.session_began(ADA, address="", role="guest")
        records.turn_began(1, ADA)
    with writing(path):
        pass
    (session,), (turn,) = rows(path, "sessions"), rows(path, "turns")
    assert session["ended_ms"] == session["seen_ms"]
    assert (turn["ended_ms"], turn["why"]) == (None, "server killed")


def test_what_lasts_is_known_again(path: Path) -> None:
    """The next server loads bans, used invitations and hosts' cookies in force."""
    until_s = time.time_ns() // 1_000_000_000 + 3600.0
    bans = (Ban("other", "", until_s), Ban("troll", "192.0.2.7", until_s))
    with writing(path) as records:
        assert records.lasting.bans == ()
        for ban in bans:
            records.keep_ban(ban)
        records.keep_ban(Ban("past", "", until_s - 7200))
        records.keep_invited(Invited("i1", "ada", "queue", until_s))
        records.keep_invited(Invited("i1", "ada", "queue", until_s))
        records.keep_host_cookie("h1", until_s - 60)
        records.keep_host_cookie("h1", until_s)
    with writing(path):  # which prunes
        pass
    lasting = load_lasting(path, SystemClock())
    assert tuple(sorted(lasting.bans, key=lambda ban: ban.identity)) == bans
    assert lasting.invited == (Invited("i1", "ada", "queue", until_s),)
    assert lasting.host_cookies == (HostCookie("h1", until_s),)


@pytest.mark.parametrize("is_folder_ours", [True, False])
@pytest.mark.parametrize("was_killed", [True, False])
def test_bans_hold_where_nothing_can_be_written(
    path: Path, monkeypatch: pytest.MonkeyPatch, *, is_folder_ours: bool, was_killed: bool
) -> None:
    """Bans hold if the file is another user's, or the disk read-only."""
    ban = Ban("troll", "192.0.2.7", time.time_ns() // 1_000_000_000 + 3600.0)
    with writing(path) as records:
        records.keep_ban(ban)
        if was_killed:
            until(lambda: load_lasting(path, SystemClock()).bans)
            path = shutil.copytree(path.parent, path.parent / "killed") / path.name
    files = sorted(path.parent.iterdir())

    def refuse(_: Path) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(state_dir, "make_private", refuse)
    monkeypatch.setattr("os.access", lambda *_: is_folder_ours)
    assert opened(path).lasting.bans == (ban,)
    assert sorted(path.parent.iterdir()) == files


def test_what_is_old_is_dropped(path: Path) -> None:
    """Rows are deleted after the configured days, and the oldest if there are too many."""
    clock = TurnedClock()
    clock.wall = 40 * DAY_MS
    records = Records(clock, writer=RecordWriter(path, keep_days=30.0, clock=clock))
    records.start()
    records.host_act(HOST, "announce", detail="old")
    records.stop(10.0)
    clock.wall += 20 * DAY_MS
    records = Records(clock, writer=RecordWriter(path, keep_days=30.0, clock=clock))
    records.start()
    records.host_act(HOST, "announce", detail="new")
    records.stop(10.0)
    assert acts(path) == ["old", "new"]
    with closing(sqlite3.connect(path, isolation_level=None)) as file:
        schema.prune(file, now_ms=clock.wall, keep_ms=30 * DAY_MS, max_rows=2)
        assert acts(path) == ["old", "new"]
        schema.prune(file, now_ms=clock.wall, keep_ms=30 * DAY_MS, max_rows=1)
        assert acts(path) == ["new"]
        schema.prune(file, now_ms=clock.wall, keep_ms=10 * DAY_MS)
        assert acts(path) == ["new"]
        schema.prune(file, now_ms=clock.wall + 11 * DAY_MS, keep_ms=10 * DAY_MS)
        assert acts(path) == []


def test_strange_text_costs_nothing_else(path: Path) -> None:
    """Surrogates, control characters and long text are stored visibly and shortened."""
    with writing(path) as records:
        records.host_act(HOST, "announce", detail="\ud800\x1b[31m\u202eevil")
        records.host_act(HOST, "announce", detail="x" * 10_000)
        records.keep_ban(Ban("\ud800", "", 1e300))  # no integer, no UTF-8
        records.host_act(HOST, "announce", detail="after")
    first, second, third = acts(path)
    assert first == r"\ud800\x1b[31m\u202eevil"
    assert len(second) == 200
    assert third == "after"


def test_a_damaged_file_is_set_aside(path: Path) -> None:
    """A damaged file is replaced without losing new records, and the log names the old one."""
    path.write_bytes(b"no database" * 1000)
    with structlog.testing.capture_logs() as logs, writing(path) as records:
        records.host_act(HOST, "announce", detail="kept")
    assert acts(path) == ["kept"]
    (aside,) = path.parent.glob("records.db.damaged-*")
    assert aside.read_bytes().startswith(b"no database")
    assert [line["file"] for line in logs if "set aside" in line["event"]] == [str(aside)]


def test_a_pipe_keeps_no_server_from_starting(path: Path) -> None:
    os.mkfifo(path)
    assert load_lasting(path, SystemClock()) == Lasting()


@pytest.mark.parametrize("table", ["acts", "host_cookies"])
def test_damage_to_a_table_keeps_the_bans(path: Path, table: str) -> None:
    """The readable rows of the lasting tables are copied to the new file."""
    until_s = time.time_ns() // 1_000_000_000 + 3600.0
    ban = Ban("troll", "192.0.2.7", until_s)
    with writing(path) as records:
        records.keep_ban(ban)
        for number in range(200):
            records.host_act(HOST, "announce", detail=str(number).ljust(150, "."))
    with closing(sqlite3.connect(path)) as file:
        asked = "SELECT rootpage FROM sqlite_master WHERE name = ?"
        (page,) = file.execute(asked, (table,)).fetchone()
        (size,) = file.execute("PRAGMA page_size").fetchone()
    with path.open("r+b") as raw:
        raw.seek((page - 1) * size)
        raw.write(b"\xff" * size)
    with writing(path) as records:
        assert records.lasting.bans == (ban,)
        records.host_act(HOST, "announce", detail="kept")
    assert acts(path) == ["kept"]
    assert load_lasting(path, SystemClock()).bans == (ban,)


@pytest.mark.parametrize("damage", ["folder", "newer", "foreign"])
def test_a_file_that_is_not_ours_is_left_alone(path: Path, damage: str) -> None:
    """Another program's file costs only the records: the log says so, and the server can end."""
    if damage == "folder":
        path.mkdir()
    else:
        with closing(sqlite3.connect(path)) as file:
            file.execute("CREATE TABLE precious (thing TEXT)")
            file.execute(f"PRAGMA user_version={99 if damage == 'newer' else 0}")
            if damage == "newer":
                file.execute(f"PRAGMA application_id={schema.APPLICATION}")
    before = b"" if path.is_dir() else path.read_bytes()
    began_s = time.monotonic()
    with structlog.testing.capture_logs() as logs, writing(path) as records:
        records.host_act(HOST, "announce", detail="lost")
        while not logs:
            time.sleep(0.01)
    assert time.monotonic() - began_s < 5
    assert [line["event"] for line in logs].count("records cannot be written") == 1
    assert records.dropped >= 1
    assert before == (b"" if path.is_dir() else path.read_bytes())


def test_a_folder_that_cannot_be_written_turns_records_off(tmp_path: Path) -> None:
    """The server runs with a warning that says what to do."""
    (tmp_path / "file").write_text("")
    with structlog.testing.capture_logs() as logs:
        records = opened(tmp_path / "file" / "records.db")
    assert records.writer is None
    assert "state_dir" in logs[0]["error"]
    records.start()
    records.host_act(HOST, "announce")
    records.stop()
    assert (records.waiting, records.dropped) == (0, 0)


@pytest.mark.system
def test_a_locked_file_is_waited_for(path: Path) -> None:
    """While another program locks the file nothing is lost, and no call blocks."""
    with writing(path) as records:
        records.host_act(HOST, "announce", detail="before")
    records = opened(path)
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        records.start()
        records.host_act(HOST, "announce", detail="meanwhile")  # otherwise it would never return
        time.sleep(2.5)  # longer than the writer waits in one step
        other.execute("ROLLBACK")
    records.stop(10.0)
    assert acts(path) == ["before", "meanwhile"]


def test_what_does_not_fit_is_counted(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While the file cannot be written the queue is bounded, and longer for lasting statements."""
    path.mkdir()
    monkeypatch.setattr(writer, "MAX_WAITING", 10)
    with writing(path) as records:
        for _ in range(20):
            records.host_act(HOST, "announce")
        assert records.dropped >= 5
        dropped = records.dropped
        records.keep_ban(Ban("troll", "", 1e9))
        assert records.dropped == dropped


def test_what_is_on_its_way_is_counted(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A statement counts as waiting until it is committed."""
    path.mkdir()
    told, goes_on = threading.Event(), threading.Event()

    class Held(SimpleQueue[Any]):
        def get(self, block: bool = True, timeout: float | None = None) -> Any:
            found = super().get(block, timeout)
            told.set()
            goes_on.wait(5.0)
            return found

    monkeypatch.setattr(writer, "SimpleQueue", Held)
    with writing(path) as records:
        assert told.wait(5.0)
        waiting = records.waiting
        goes_on.set()
    assert waiting == 2  # closed at each start: visits and turns


_FULL = """
import resource, sys, time
from wax.clock import SystemClock
from wax.config.records import RecordSettings
from wax.records import writer
from wax.records.entries import RecordedPerson
from wax.records.opening import open_records
writer.RETRY_S = 600.0
records = open_records(RecordSettings(path=sys.argv[1]), "", SystemClock())
records.start()
host = RecordedPerson("host", "Hedy")
records.host_act(host, "announce", detail="before")
while records.waiting:
    time.sleep(0.01)
resource.setrlimit(resource.RLIMIT_FSIZE, (1, resource.RLIM_INFINITY))  # nothing fits
for number in range(3000):
    records.host_act(host, "announce", detail=str(number).ljust(150, "."))
    if number == 2000:
        time.sleep(1.0)  # the writer has tried, and waits
waiting = records.waiting
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
records.host_act(host, "announce", detail="after")
records.stop(10.0)
print(waiting, records.dropped)
"""


@pytest.mark.system
def test_a_full_disk_costs_nothing_that_fits_in_memory(path: Path) -> None:
    """No call blocks while the disk is full, and everything is written afterwards.

    The writer waits longer than the calls may take, so a call that waited for it never returned.
    """
    said = subprocess.run(
        [sys.executable, "-c", _FULL, str(path)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    waiting, dropped = map(int, said.stdout.splitlines()[-1].split())
    assert (waiting, dropped) == (3000, 0)
    assert [acts(path)[0], len(acts(path)), acts(path)[-1]] == ["before", 3002, "after"]


_ENDLESS = """
import sys, time
from pathlib import Path
from wax.clock import SystemClock
from wax.records.entries import RecordedPerson
from wax.records.opening import load_lasting
from wax.records.records import Records
from wax.records.writer import RecordWriter
clock, path = SystemClock(), Path(sys.argv[1])
lasting = load_lasting(path, clock)  # which makes the file, as a server does before it serves
records = Records(clock, lasting, RecordWriter(path, keep_days=30.0, clock=clock))
records.start()
number = 0
while True:
    number += 1
    records.host_act(RecordedPerson("host", "Hedy"), "announce", detail=str(number))
    print(number, time.time_ns() // 1_000_000, flush=True)
    time.sleep(0.0005)
"""


def _kill_while_it_writes(path: Path, after_s: float) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", _ENDLESS, str(path)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    told: list[tuple[int, int]] = []
    deadline_s = float("inf")
    with process.stdout as lines:
        for line in lines:
            number, at_ms = map(int, line.split())
            told.append((number, at_ms))
            if number == 1:
                deadline_s = time.monotonic() + after_s
            if time.monotonic() > deadline_s:
                break
        process.send_signal(signal.SIGKILL)
        *rest, _ = lines.read().split("\n")  # the last may have been cut off
        told += [(int(number), int(at_ms)) for number, at_ms in map(str.split, rest)]
        process.wait()
    last_ms = told[-1][1]
    with closing(sqlite3.connect(path)) as file:
        assert file.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    kept = [int(detail) for detail in acts(path)]
    assert kept == list(range(1, len(kept) + 1))  # no holes
    missing_ms = max((last_ms - at_ms for number, at_ms in told if number > len(kept)), default=0)
    assert missing_ms <= 1000


@pytest.mark.system
@pytest.mark.timeout(600)
@pytest.mark.parametrize("times", [2, pytest.param(100, marks=pytest.mark.full)])
def test_killed_while_it_writes(tmp_path: Path, times: int) -> None:
    """After SIGKILL at any time the file opens and lacks at most the last second."""
    after_s = [1.1 + 0.7 * number / times for number in range(times)]
    paths = [tmp_path / f"{number}.db" for number in range(times)]
    with ThreadPoolExecutor(5) as at_once:
        list(at_once.map(_kill_while_it_writes, paths, after_s))


def test_rows_are_plain_values(path: Path) -> None:
    """Stored values can be exported unchanged."""
    with writing(path) as records:
        records.session_began(ADA, address="2001:db8:1:2::/64", role="guest")
    json.dumps(rows(path, "sessions"))
    assert rows(path, "sessions")[0]["address"] == "2001:db8:1::/48"


def test_a_power_cut_takes_no_commit(path: Path) -> None:
    """Each commit is on disk when it returns (SQLite, PRAGMA synchronous: 2 is FULL)."""
    with closing(open_for_writing(path)) as file:
        assert file.execute("PRAGMA synchronous").fetchone() == (2,)
