"""What the records are told: who was here, who drove, what stopped the robot."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import pytest
import structlog
from tests.heard_events import Heard
from tests.session.served_viewer import served_viewer
from tests.turned_clock import TurnedClock

from wax.control.reasons import NOT_HELD, Hold, Limit, Refusal, stopped_by
from wax.control.turns import TurnEnded, TurnRenewed, TurnStarted, Why
from wax.fanout.batches import PORTION
from wax.records.file import open_for_reading
from wax.records.records import Records
from wax.records.writer import RecordWriter
from wax.sentence import Sentence, says
from wax.session.record_keeper import DriveStatus, RecordKeeper, refused, why_stopped
from wax.streams.interface import StreamState

if TYPE_CHECKING:
    from pathlib import Path

    from wax.records.entries import RecordedPerson
    from wax.session.viewer import Viewer


class BrokenStreams:
    """Streams of a viewer whose status cannot be had."""

    def status(self) -> StreamState:
        raise RuntimeError("bug")


class Rig:
    """A keeper over viewers and counts that the test sets, and what it has written."""

    def __init__(self, path: Path) -> None:
        self.clock = TurnedClock()
        self.path = path
        self.viewers: list[Viewer] = []
        self.counts: dict[str, int] = {}
        self.heard = Heard(self.clock)
        self.records = Records(
            self.clock, writer=RecordWriter(path, keep_days=30.0, clock=self.clock)
        )
        self.keeper = RecordKeeper(
            records=self.records,
            clock=self.clock,
            viewers=self.viewers,
            refused=lambda: dict(self.counts),
            event_maker=self.heard.event_maker,
        )

    def written(self, table: str) -> list[dict[str, Any]]:
        """End the keeper and the records, and read what they wrote."""
        self.keeper.close()
        self.records.start()
        self.records.stop(10.0)
        with closing(open_for_reading(self.path)) as file:
            file.row_factory = sqlite3.Row
            return [dict(row) for row in file.execute(f"SELECT * FROM {table} ORDER BY 1")]


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    return Rig(tmp_path / "records.db")


def test_a_visit_has_its_link(rig: Rig) -> None:
    """Its record has medians and worst values of all polls, and the newest name."""
    ada = served_viewer(1, "Guest 1")
    rig.viewers += [ada, served_viewer(2, "not connected", ready=False)]
    rig.keeper.poll()
    ada.name = "Ada"
    ada.link.newest_s = 0.2
    rig.keeper.poll()
    rig.viewers.clear()
    rig.keeper.poll()
    (row,) = rig.written("sessions")
    assert (row["name"], row["address"], row["role"]) == ("Ada", "192.0.2.0/24", "guest")
    assert row["ended_ms"] is not None
    assert row["round_trip_ms"] == pytest.approx(40, rel=0.03)
    assert row["round_trip_worst_ms"] == 200
    assert (row["picture_age_worst_ms"], row["sound_age_worst_ms"]) == (90, 120)
    assert (row["lost_percent"], row["rendition"]) == (1.0, "640x480")


def test_the_host_is_recorded_as_host(rig: Rig) -> None:
    """The role decides, not the name."""
    rig.viewers += [served_viewer(1, "Hedy"), served_viewer(2, "Ada")]
    rig.keeper.poll()
    assert {row["name"]: row["role"] for row in rig.written("sessions")} == {
        "Hedy": "host",
        "Ada": "guest",
    }


def test_a_broken_viewer_costs_only_their_figures(rig: Rig) -> None:
    """Everybody else's visit is recorded, theirs without a link."""
    rig.viewers += [served_viewer(1, "Eve", streams=BrokenStreams()), served_viewer(2, "Ada")]
    rig.keeper.poll()
    rows = {row["name"]: row["rendition"] for row in rig.written("sessions")}
    assert rows == {"Eve": None, "Ada": "640x480"}


async def test_polling_a_crowd_leaves_room_for_timers(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The control loop does not wait until each of many viewers is polled, or recorded."""
    looked: list[int] = []
    noted_visits: list[str] = []
    began = rig.records.session_began

    def begins(person: RecordedPerson, **about: str) -> int:
        noted_visits.append(person.name)
        return began(person, **about)

    monkeypatch.setattr(rig.records, "session_began", begins)

    def noted(number: int) -> StreamState:
        looked.append(number)
        return StreamState({})

    for number in range(20):
        rig.viewers.append(served_viewer(number, f"Guest {number}"))
        rig.viewers[-1].streams.status = partial(noted, number)  # type: ignore[method-assign]
    rig.keeper.poll()
    for _ in range(20):
        before = len(looked)
        assert len(noted_visits) == before
        await asyncio.sleep(0)
        assert len(looked) - before <= PORTION
    assert looked == list(range(20))


async def test_a_visit_that_has_ended_stays_so(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """The minute's update, spread over time for a crowd, leaves out people who have left since."""
    is_over: dict[int, bool] = {}

    def seen(number: int, *_: object, **how: bool) -> None:
        is_over[number] = how["is_over"]

    monkeypatch.setattr(rig.records, "session_seen", seen)
    rig.viewers += [served_viewer(number, f"Guest {number}") for number in range(2 * PORTION)]
    rig.keeper.poll()
    await asyncio.sleep(0)
    rig.clock.time_s += 60.0
    rig.keeper.poll()
    rig.viewers.clear()
    rig.keeper.poll()
    for _ in range(PORTION):
        await asyncio.sleep(0)
    assert list(is_over.values()) == [True] * 2 * PORTION


def test_turns_say_why_they_ended(rig: Rig) -> None:
    """The turn of a server that stops ends with it; a renewed one is one turn."""
    rig.viewers += [served_viewer(1, "Ada"), served_viewer(2, "Bob")]
    rig.keeper.turn_events((TurnStarted(1, 1, 60.0), TurnRenewed(1, 1, 120.0)))
    rig.keeper.turn_events((TurnEnded(1, 1, Why.LEFT), TurnStarted(2, 2, 180.0)))
    rows = [(row["number"], row["name"], row["why"]) for row in rig.written("turns")]
    assert rows == [(1, "Ada", "left"), (2, "Bob", "server stopped")]
    assert rig.heard.take() == [
        {"type": "turn.began", "turn": 1, "viewer": 1, "name": "Ada"},
        {"type": "turn.ended", "turn": 1, "viewer": 1, "name": "Ada", "why": "left"},
        {"type": "turn.began", "turn": 2, "viewer": 2, "name": "Bob"},
        {"type": "turn.ended", "turn": 2, "viewer": 2, "name": "Bob", "why": "server_ending"},
    ]


def test_stops_have_who_and_until_when(rig: Rig) -> None:
    """A second press of the same Stop is no second row; somebody without a page is named."""
    ada = served_viewer(1, "Ada")
    rig.keeper.stop_pressed(ada, "Ada", 1, "operator")
    rig.keeper.stop_pressed(None, "somebody", 2, "observer")
    rig.keeper.stop_released(None, "Hedy", 1, "host")
    rig.keeper.stop_released(None, "Hedy", 1, "host")
    rig.keeper.stop_pressed(None, "somebody", 3, "observer")
    rows = rig.written("stops")
    assert [(row["number"], row["name"], row["released_by"]) for row in rows] == [
        (1, "Ada", "Hedy"),
        (3, "somebody", None),
    ]
    assert rows[1]["person"] == ""
    assert rig.keeper.stops == {"pressed": 3}
    assert rig.heard.take() == [
        {"type": "stop.pressed", "stop": 1, "role": "operator", "name": "Ada"},
        {"type": "stop.released", "stop": 1, "role": "host", "name": None},
        {"type": "stop.pressed", "stop": 3, "role": "observer", "name": None},
    ]


@pytest.mark.parametrize(
    ("reason", "told"),
    [
        (Refusal.TOO_OLD.value, "too old"),
        (Refusal.BLIND.value, "blind"),
        (Hold.LATE.value, "late"),
        (says("The serial line is gone."), "robot: The serial line is gone."),
        (None, None),
        (NOT_HELD, None),
        (Limit.LATE_PICTURE.value, None),
    ],
)
def test_what_stops_a_moving_robot_is_recorded(
    rig: Rig, reason: Sentence | None, told: str | None
) -> None:
    """A stop is recorded once, with the operator; one that the operator wanted is none."""
    rig.viewers.append(served_viewer(1, "Ada"))
    rig.keeper.drive_status(1, False, Hold.TURN_STARTED.value, 1.0)
    rig.keeper.drive_status(1, True, None, 1.0)
    rig.keeper.drive_status(1, True, reason, 1.0)
    rig.keeper.drive_status(1, False, reason, 1.0)
    rows = rig.written("stops")
    assert [row["reason"] for row in rows] == ([] if told is None else [told])
    assert [(row["name"], row["number"]) for row in rows] == [("Ada", None)] * len(rows)
    assert rig.keeper.stops.total() == len(rows)


def test_a_pressed_stop_is_recorded_once(rig: Rig) -> None:
    """The reason that the gate gives while it lasts is not another stop."""
    rig.viewers.append(served_viewer(1, "Ada"))
    rig.keeper.drive_status(1, True, None, 1.0)
    rig.keeper.stop_pressed(None, "somebody", 1, "observer")
    rig.keeper.drive_status(1, False, stopped_by(says("somebody")), 1.0)
    assert len(rig.written("stops")) == 1


def test_a_bad_link_does_not_fill_the_file(rig: Rig) -> None:
    """Many interruptions a second are all counted, but only one a second is a row."""
    rig.viewers.append(served_viewer(1, "Ada"))
    for _ in range(30):
        rig.keeper.drive_status(1, True, None, 1.0)
        rig.keeper.drive_status(1, False, Refusal.TOO_OLD.value, 1.0)
        rig.clock.time_s += 0.1
    assert rig.keeper.stops == {"too_old": 30}
    assert len(rig.written("stops")) == 3
    event = {"type": "stop.automatic", "viewer": 1, "why": "too_old", "name": "Ada"}
    assert rig.heard.take() == [event] * 3


def test_refusals_are_counts(rig: Rig) -> None:
    """What has grown since the last minute is added to the hour's row."""
    rig.counts = {"requests refused": 2}
    rig.clock.time_s += 61
    rig.keeper.poll()
    rig.counts = {"requests refused": 5, "messages over the rate": 1}
    rows = {row["reason"]: row["count"] for row in rig.written("refusals")}
    assert rows == {"requests refused": 5, "messages over the rate": 1}


def test_which_counts_are_refusals() -> None:
    """Refusals by the room, the gate and the Stop are found by their names."""
    counts = {"requests refused": 1, "commands.refused.lost": 2.0, "commands.accepted": 3}
    assert refused(counts) == {"requests refused": 1, "commands.refused.lost": 2.0}


def test_an_error_stays_in_the_keeper(rig: Rig) -> None:
    """The control loop calls the keeper, which never raises, and logs the error once."""
    rig.viewers.append(cast("Viewer", object()))
    with structlog.testing.capture_logs() as logs:
        rig.keeper.poll()
        rig.keeper.turn_events((TurnStarted(1, 1, 60.0),))
    assert [line["event"] for line in logs] == ["the records are incomplete"]


def test_every_end_of_a_turn_has_its_event(rig: Rig) -> None:
    """Whatever ends one, its code is among those that the schema lists."""
    for number, why in enumerate(Why, 1):
        rig.keeper.turn_events((TurnStarted(number, 1, 60.0), TurnEnded(number, 1, why)))
    told = [one["why"] for one in rig.heard.take() if one["type"] == "turn.ended"]
    assert told == [why.name.lower() for why in Why]


def test_a_server_that_served_says_that_it_ends(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its event has version and time; a server that was never ready sends none."""
    monkeypatch.setattr(rig.clock, "wall_ms", lambda: 1_764_158_400_123)
    rig.keeper.close()
    assert rig.heard.take() == []
    rig.keeper.event_maker.ready("1.2")
    rig.keeper.poll()
    rig.keeper.close()
    assert rig.heard.events[0].timestamp == "2025-11-26T12:00:00.123+00:00"
    assert [one["type"] for one in rig.heard.take()] == [
        "server.ready",
        "door.opened",
        "server.ending",
    ]


def test_events_that_fail_cost_no_record(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the records nor the control loop notice; the log says so once."""

    def fail(*_: object) -> None:
        raise RuntimeError("bug")

    monkeypatch.setattr(rig.keeper.event_maker, "_send", fail)
    monkeypatch.setattr(rig.keeper.event_maker, "_seen", fail)
    rig.viewers.append(served_viewer(1, "Ada"))
    with structlog.testing.capture_logs() as logs:
        rig.keeper.poll()
        rig.keeper.turn_events((TurnStarted(1, 1, 60.0), TurnEnded(1, 1, Why.LEFT)))
    assert [line["event"] for line in logs] == ["events are missing"]
    assert [row["why"] for row in rig.written("turns")] == ["left"]


@pytest.mark.parametrize(
    ("before", "now", "why"),
    [
        (None, (7, False, Refusal.TOO_OLD.value), None),
        ((7, True, None), (7, True, Refusal.TOO_OLD.value), "too_old"),
        ((7, True, None), (7, False, says("The left wheel is off.")), "robot"),
        ((7, False, None), (7, False, Refusal.TOO_OLD.value), None),
        ((7, True, None), (8, False, Refusal.TOO_OLD.value), None),
        ((7, True, None), (7, False, NOT_HELD), None),
        ((7, True, None), (7, True, Limit.LONG_DELAY.value), None),
        ((7, True, None), (7, False, None), None),
    ],
)
def test_a_fault_is_an_involuntary_stop(
    before: DriveStatus | None, now: DriveStatus, why: str | None
) -> None:
    """A hand-over, a released button and a mere speed limit are none."""
    assert why_stopped(before, now) == why


def _turn(rig: Rig, number: int, *, lasts_s: float = 0.0, drives: bool = False) -> None:
    rig.keeper.turn_events((TurnStarted(number, 1, 60.0),))
    rig.clock.time_s += lasts_s
    if drives:
        rig.keeper.drive_status(1, True, None, 1.0)
    rig.keeper.poll()
    rig.keeper.turn_events((TurnEnded(number, 1, Why.LEFT),))


def test_a_flood_of_empty_turns_is_a_number(rig: Rig) -> None:
    """Of hundreds, a few are recorded and reported, and the rest is counted; a Stop always is."""
    rig.viewers += [served_viewer(1, "Eve")]
    for number in range(1, 901):
        _turn(rig, number)
        rig.clock.time_s += 0.01
    rig.keeper.stop_pressed(rig.viewers[0], "Eve", 1, "observer")
    told = [one["type"] for one in rig.heard.take()]
    assert told.count("turn.began") == told.count("turn.ended") == 21
    assert told[-1] == "stop.pressed"
    assert {row["reason"]: row["count"] for row in rig.written("refusals")} == {
        "turns over the rate": 879
    }


@pytest.mark.parametrize(("lasts_s", "drives"), [(2.0, False), (0.1, True)])
def test_a_turn_that_is_driven_or_lasts_is_reported_in_a_flood(
    rig: Rig, lasts_s: float, *, drives: bool
) -> None:
    """It has its number and its end, since it is not an empty one."""
    rig.viewers += [served_viewer(1, "Eve")]
    for number in range(1, 31):
        _turn(rig, number)
    rig.heard.take()
    _turn(rig, 31, lasts_s=lasts_s, drives=drives)
    told = [(one["type"], one["turn"]) for one in rig.heard.take()]
    assert told == [("turn.began", 31), ("turn.ended", 31)]
