"""`wax records`: the same rows for people and programs, and a sentence for every bad file."""

from __future__ import annotations

import csv
import io
import json
import os
import sqlite3
from contextlib import closing
from itertools import pairwise
from typing import TYPE_CHECKING

import pytest
from tests.turned_clock import TurnedClock

from wax.__main__ import main
from wax.records import file as record_file
from wax.records import reading
from wax.records.entries import LinkSummary, RecordedPerson
from wax.records.records import Records
from wax.records.schema import APPLICATION, EXPORTED
from wax.records.writer import RecordWriter

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

ADA = RecordedPerson("ada-11111111", "=Ada")
NOV_1_MS = 1_793_491_200_000
DAY_MS = 86_400_000


def fill(path: Path, turns: int = 1) -> None:
    clock = TurnedClock()
    clock.wall = NOV_1_MS
    records = Records(clock, writer=RecordWriter(path, keep_days=30.0, clock=clock))
    records.start()
    visit = records.session_began(ADA, address="192.0.2.7", role="guest")
    for number in range(1, turns + 1):
        turn = records.turn_began(number, ADA)
        clock.wall += DAY_MS
        records.turn_ended(turn, "expired")
    records.session_seen(visit, ADA, "guest", LinkSummary(round_trip_ms=41.25))
    records.stop(10.0)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    fill(tmp_path / "records.db")
    return tmp_path / "records.db"


def shown(capsys: pytest.CaptureFixture[str], path: Path, *arguments: str) -> str:
    capsys.readouterr()
    assert main(["records", "--file", str(path), *arguments]) == 0
    return capsys.readouterr().out


def test_everything_without_options(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every table is printed in columns, and an empty one is named."""
    text = shown(capsys, path)
    assert "1 turn:" in text
    assert "2026-11-01T00:00:00.000Z" in text
    assert "41.25" in text
    assert "192.0.2.0/24" in text
    assert "No acts." in text
    header, row = next(pair for pair in pairwise(text.splitlines()) if "why" in pair[0])
    assert header.index("why") == row.index("expired")


def test_json_and_csv_have_every_column(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Programs get all values in both, and a spreadsheet does not run a name as a formula."""
    (turn,) = json.loads(shown(capsys, path, "turns", "--json"))
    assert turn == {
        "began": "2026-11-01T00:00:00.000Z",
        "ended": "2026-11-02T00:00:00.000Z",
        "number": 1,
        "person": turn["person"],
        "name": "=Ada",
        "why": "expired",
    }
    (read,) = csv.DictReader(io.StringIO(shown(capsys, path, "turns", "--csv")))
    assert read == {**{name: str(value) for name, value in turn.items()}, "name": "'=Ada"}
    everything = json.loads(shown(capsys, path, "--json"))
    assert list(everything) == list(EXPORTED)
    assert everything["turns"] == [turn]
    empty = shown(capsys, path, "refusals", "--csv")
    assert empty == "began,reason,count\n"


@pytest.mark.parametrize(
    ("since", "count"),
    [("2026-11-01", 1), ("2026-11-01T00:00:01", 0), ("2026-11-01T00:30+01:00", 1)],
)
def test_since(path: Path, capsys: pytest.CaptureFixture[str], since: str, count: int) -> None:
    """A date with or without a time is UTC unless it has an offset."""
    assert len(json.loads(shown(capsys, path, "turns", "--json", "--since", since))) == count


def test_the_newest_are_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """People see the newest rows, programs get all of them."""
    fill(tmp_path / "records.db", turns=60)
    text = shown(capsys, tmp_path / "records.db", "turns")
    assert text.count("expired") == 50
    assert "60 turns:" in text
    assert "10 older" in text
    assert "2026-12-30" in text
    assert shown(capsys, tmp_path / "records.db", "turns", "--csv").count("expired") == 60


def test_it_is_found_as_configured(
    path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a file name it reads the configured server's file."""
    (path.parent / "wax").mkdir()
    path.rename(path.parent / "wax" / "records.db")
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(path.parent))
    assert main(["records", "turns"]) == 0
    assert "expired" in capsys.readouterr().out
    config = path.parent / "wax.toml"
    config.write_text(f'[server]\nstate_dir = "{path.parent / "other"}"\n')
    assert main(["records", "turns", "--config", str(config)]) == 1
    assert "other/records.db: there are no records" in capsys.readouterr().err


def _foreign(path: Path) -> None:
    with closing(sqlite3.connect(path)) as file:
        file.execute("CREATE TABLE precious (thing TEXT)")


def _newer(path: Path) -> None:
    with closing(sqlite3.connect(path)) as file:
        file.execute(f"PRAGMA application_id={APPLICATION}")
        file.execute("PRAGMA user_version=99")


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    "missing": (lambda _: None, "there are no records"),
    "empty": (lambda path: path.write_bytes(b""), "there are no records"),
    "a folder": (lambda path: path.mkdir(), "cannot be read"),
    "damaged": (lambda path: path.write_bytes(b"no database" * 1000), "is damaged"),
    "foreign": (_foreign, "another program"),
    "newer": (_newer, "newer version"),
}


@pytest.mark.parametrize("bad", BAD)
def test_a_bad_file_is_a_sentence(
    bad: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The sentence names the file and its fault, and the status is 1."""
    path = tmp_path / "records.db"
    make, says = BAD[bad]
    make(path)
    assert main(["records", "turns", "--file", str(path)]) == 1
    told = capsys.readouterr()
    assert str(path) in told.err
    assert says in told.err
    assert (told.out, told.err.count("\n")) == ("", 1)


def test_a_locked_file_is_a_sentence(
    path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A locked file is an error after a moment, not an endless wait."""
    monkeypatch.setattr(record_file, "BUSY_S", 0.05)
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("PRAGMA locking_mode=EXCLUSIVE")
        other.execute("BEGIN EXCLUSIVE")
        assert main(["records", "turns", "--file", str(path)]) == 1
    assert "locked" in capsys.readouterr().err


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_a_file_of_another_user_is_a_sentence(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The sentence says which user to run it as."""
    path.chmod(0)
    assert main(["records", "turns", "--file", str(path)]) == 1
    assert "run this as the server's user" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [(["turns", "--since", "yesterday"], "2026-11-01"), (["--csv"], "turns")],
)
def test_wrong_use_is_a_sentence(
    path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], says: str
) -> None:
    """A wrong argument is answered with the right ones, and the status is 2."""
    assert main(["records", "--file", str(path), *arguments]) == 2
    assert says in capsys.readouterr().err


def test_it_is_read_while_it_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Rows recorded a second ago are there, and the writer is not disturbed."""
    path = tmp_path / "records.db"
    clock = TurnedClock()
    clock.wall = NOV_1_MS
    records = Records(clock, writer=RecordWriter(path, keep_days=30.0, clock=clock))
    records.start()
    for number in range(12):
        records.turn_began(number, ADA)
        if path.exists():
            main(["records", "turns", "--json", "--file", str(path)])
    records.stop(10.0)
    assert records.dropped == 0
    assert len(json.loads(shown(capsys, path, "turns", "--json"))) == 12


def test_impossible_times_are_none() -> None:
    """A row of the year 300000 is shown without its time."""
    assert reading._iso(10**16) is None
