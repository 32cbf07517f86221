"""The suite's arithmetic: a figure that is wrong in the report is worse than none."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from e2e.load.cluster.driver import sweep
from e2e.load.cluster.driving import changes_ms, stops
from e2e.load.cluster.next_operator import TURN_S, Turns
from e2e.load.cluster.page import longest_gap_ms, unix_ms
from e2e.measure.errors import MeasureError
from e2e.stop.record import Record


def test_a_gap_is_counted_from_before_its_edge() -> None:
    """What stood when the fault came had stood for a while; what came after it ends the gap."""
    shown_ms = [0.0, 30.0, 60.0, 900.0, 930.0]
    assert longest_gap_ms(shown_ms, 100.0, 500.0) == 840.0
    assert longest_gap_ms(shown_ms, 10.0, 50.0) == 30.0
    for from_ms, to_ms in ((-1.0, 50.0), (100.0, 931.0)):
        with pytest.raises(MeasureError):
            longest_gap_ms(shown_ms, from_ms, to_ms)


def test_each_command_has_another_speed() -> None:
    """Nor does the board see the same one again in the next frame."""
    shares = [sweep(seq) for seq in range(1000)]
    assert all(abs(a - b) > 0.004 for a, b in pairwise(shares))
    assert 0.2 < min(shares) < max(shares) < 0.9


def test_commands_and_stops_are_read_off_the_line() -> None:
    """The same speed again is no new command; only what stands after a motion is a stop."""

    def frame(kind: str, speed: int, verdict: str = "taken") -> dict[str, Any]:
        return {"event": "frame", "type": kind, "verdict": verdict, "turn": 1} | {
            "left": speed,
            "right": -speed,
        }

    log = [
        frame("stop", 0),
        frame("drive", 5),
        frame("drive", 5),
        frame("drive", 6),
        frame("drive", 9, "late"),
        frame("stop", 0),
        frame("stop", 0),
        frame("drive", 6),
    ]
    record = Record(Path("unread"))
    record.take([one | {"t_s": float(at_s)} for at_s, one in enumerate(log)])
    assert changes_ms(record.frames) == [unix_ms(at_s) for at_s in (0, 1, 3, 5, 7)]
    assert stops(record.frames, unix_ms(0), unix_ms(7)) == 1
    assert stops(record.frames, unix_ms(6), unix_ms(7)) == 0


def test_a_turn_begins_its_length_before_its_end() -> None:
    """By the server's clock, which is not this process's; and each is taken once."""
    turns = Turns()
    turns.ahead_ms = 500.0
    room = {
        "type": "room",
        "viewers": [{"id": 7, "name": "Ada"}],
        "turn": {"number": 3, "operator": 7, "ends_server_ms": 20_500.0},
    }
    turns.learn({"type": "hello"})
    turns.learn(room)
    turns.learn(room | {"turn": room["turn"] | {"ends_server_ms": 99_000.0}})  # type: ignore[operator]  # it is a table
    turns.learn(room | {"turn": {"number": 4, "operator": None, "ends_server_ms": None}})
    (turn,) = turns.begun.values()
    assert (turn.name, turn.begins_ms) == ("Ada", unix_ms(20.0 - TURN_S))
