"""The suite's own arithmetic on a board's log."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

import pytest

from e2e.measure.row import Row, timed
from e2e.stop.hand_over import switches
from e2e.stop.harm import NO_COMMANDS, NO_STOPS, STOP, corrupted, no_releases
from e2e.stop.nuisance import Arrival, arrivals, halts, replayed
from e2e.stop.operator import Sent
from e2e.stop.record import Record
from e2e.stop.relay import Packet
from e2e.stop.steady_beat import own_beat
from e2e.stop.suite import staged_case
from wax.errors import ProtocolError
from wax.protocol.messages import parse_drive, parse_state

if TYPE_CHECKING:
    from collections.abc import Callable


def frame(at_s: float, kind: str = "drive", *, speed: int = 100, turn: int = 1) -> dict[str, Any]:
    speed = speed if kind == "drive" else 0
    return {
        "t_s": at_s,
        "event": "frame",
        "type": kind,
        "verdict": "taken",
        "turn": turn,
        "left": speed,
        "right": speed,
    }


def wheels(at_s: float, speed: int) -> dict[str, Any]:
    return {"t_s": at_s, "event": "wheels", "left": speed, "right": speed}


def record(*events: dict[str, Any]) -> Record:
    found = Record(Path("unread"))
    found.take(events)
    return found


def test_a_stop_is_timed_to_its_first_frame_and_to_standing_wheels() -> None:
    """The first frame that stops counts, not a later one, and the wheels are told apart."""
    seen = record(
        frame(1.0), wheels(1.0, 100), frame(1.1, "stop"), wheels(1.15, 0), frame(1.2, "stop")
    )
    stopping = seen.stopping(1.05, 2.0)
    assert seen.moved_at(1.05)
    assert stopping.told_ms == pytest.approx(50)
    assert stopping.stands_ms == pytest.approx(100)
    assert stopping.by_itself_ms is None
    assert stopping.moved_again == 0


def test_the_way_to_standstill_is_never_too_short() -> None:
    """The faster wheel counts, whichever way it turns, and of a span its faster end."""
    seen = record(frame(1.0), wheels(1.0, 600), frame(1.1, "stop"), wheels(1.1, 580))
    assert seen.stopping(1.05, 2.0).travelled_mm is None
    seen.take([wheels(1.13, 0), wheels(1.5, 300), wheels(1.6, 0)])
    assert seen.stopping(1.05, 2.0).travelled_mm == pytest.approx(600 * 0.05 + 580 * 0.03)
    assert seen.stopping(1.05, 1.12).travelled_mm is None
    curve = {"t_s": 1.0, "event": "wheels", "left": 100, "right": -400}
    turning = record(frame(1.0), curve, wheels(1.2, 0))
    assert turning.stopping(1.1, 2.0).travelled_mm == pytest.approx(40)


def test_motion_after_a_stop_is_counted() -> None:
    """Each frame that moves the robot after it was stopped is wrong."""
    seen = record(frame(1.0), wheels(1.0, 100), frame(1.1, "stop"), frame(1.2), frame(1.3))
    assert seen.stopping(1.05, 2.0).moved_again == 2
    assert seen.stopping(1.05, 1.25).moved_again == 1


def test_a_stop_that_never_comes_misses_every_goal() -> None:
    """A robot that keeps moving misses the goal; its figure is not left out."""
    seen = record(frame(1.0), wheels(1.0, 100), frame(1.1), frame(1.2))
    stopping = seen.stopping(1.05, 2.0)
    assert stopping.told_ms is None
    assert not timed("x", "y", [100.0, stopping.told_ms], 200.0).met
    assert timed("x", "y", [100.0, 120.0], 200.0).met
    assert not timed("x", "y", [100.0, 120.0], 200.0, wrong=1).met


def test_rows_say_under_which_load() -> None:
    """What is measured on the stage says what the server served meanwhile."""

    async def measure(n: int) -> Row:
        return timed("x", "y", [float(n)], 5.0)

    (row,) = staged_case("x", 9, measure, "trials").run(2)
    assert (row.load, row.values["max"]) == ("640×480 at 30 fps, sound, 20 observers", 2.0)


def test_a_robot_that_stood_before_was_not_moving() -> None:
    """A trial in which the robot had already stopped does not count."""
    seen = record(frame(1.0), wheels(1.0, 100), frame(1.1, "stop"), wheels(1.12, 0))
    assert seen.moved_at(1.05)
    assert not seen.moved_at(1.11)
    assert not seen.moved_at(1.5)
    assert not record(frame(1.0), wheels(1.0, 100)).moved_at(1.2)


DIRECTIONS = {1: 1, 2: -1}


def test_a_good_switch_is_a_stop_and_then_the_new_hands() -> None:
    """Nothing is wrong with it, and its gap is from the turn's first frame to its first motion."""
    stop, back = frame(1.15, "stop", turn=2), frame(1.2, speed=-100, turn=2)
    good = record(frame(1.0), frame(1.1, "stop"), stop, back).frames
    found = switches(good, DIRECTIONS)
    assert (found.n, found.old, found.foreign, found.without_stop) == (1, 0, 0, 0)
    assert found.gaps_ms[0] == pytest.approx(50)
    assert switches(good, DIRECTIONS, slow={2}).gaps_ms == ()


def test_a_late_frame_is_found_though_the_board_refuses_it() -> None:
    """Motion for a turn that is over counts on the wire, and so does a switch without a stop."""
    refused = frame(1.3) | {"verdict": "old turn"}
    found = switches(record(frame(1.0), frame(1.2, speed=-100, turn=2), refused).frames, DIRECTIONS)
    assert (found.old, found.foreign, found.without_stop) == (1, 0, 1)


def test_the_hands_of_the_operator_before_are_found_under_the_new_number() -> None:
    """Motion is foreign if the turn's operator drives the other way, or never had the turn."""
    frames = record(frame(1.0), frame(1.1, "stop"), frame(1.2, turn=2), frame(1.3, turn=3)).frames
    assert switches(frames, DIRECTIONS).foreign == 2


def test_halts_are_counted() -> None:
    """Each standstill after motion is one, however long it lasts."""
    frames = [frame(1.0), frame(1.1, "stop"), frame(1.2, "stop"), frame(1.3), frame(1.4, "stop")]
    assert halts(record(*frames).frames) == 2


def test_a_stall_of_the_loop_is_a_long_gap() -> None:
    """One beat that is 100 ms late hardly changes the jitter, and misses the goal of the gap."""
    counted = {"control.jitter_p99_ms": 4.9, "control.latest_ms": 100.0}
    jitter, gap = own_beat(counted, 3000)
    assert (jitter.met, gap.met, gap.values) == (True, False, {"max": 120.0})
    late, good = own_beat({"control.jitter_p99_ms": 5.1, "control.latest_ms": 20.0}, 3000)
    assert (late.met, good.met) == (False, True)


def test_packets_are_matched_with_the_commands_that_they_carried() -> None:
    """A lost packet loses its command, and an acknowledgement carries none."""
    sent = [Sent(1, 0.00), Sent(2, 0.02), Sent(3, 0.04)]
    packets = [
        Packet(0.001, 150, 0.061),
        Packet(0.010, 65, 0.070),
        Packet(0.021, 150, None),
        Packet(0.041, 150, 0.101),
    ]
    assert arrivals(sent, packets) == [Arrival(0.061, 1, 0.00), Arrival(0.101, 3, 0.04)]


def test_a_shorter_time_to_live_stops_more_often() -> None:
    """A hole of 0.2 s in the arrivals stops by 100 ms and not by 300."""
    times = [i * 0.02 for i in range(50)] + [1.18 + i * 0.02 for i in range(50)]
    found = [Arrival(at_s + 0.001, seq, at_s) for seq, at_s in enumerate(times, 1)]
    assert replayed(found, 0.0, 100) == 1
    assert replayed(found, 0.0, 300) == 0


COMMAND: dict[str, Any] = {
    "turn": 2,
    "sent_server_ms": 1234.5,
    "linear": -1.0,
    "angular": 0.0,
    "held": True,
    "speed": "fast",
    "seen_server_ms": None,
    "axes": {},
    "beat": "x7-_2A",
}
RELEASE: dict[str, Any] = {"type": "release", "stop": 12, "sent_server_ms": 1234.5, "beat": None}


def row(command: dict[str, Any]) -> str:
    return json.dumps(["drive", 7, *command.values()])


@pytest.mark.parametrize(
    ("parse", "text"),
    [(parse_drive, row(COMMAND)), (parse_state, STOP), (parse_state, json.dumps(RELEASE))],
    ids=["drive", "stop", "release"],
)
def test_what_is_corrupted_cannot_be_meant(parse: Callable[[str], object], text: str) -> None:
    """No damaged message is one that the codec would take."""
    random = Random(1)
    parse(text)
    for _ in range(1000):
        damaged = corrupted(text, random)
        with pytest.raises(ProtocolError):
            parse(damaged)


def test_what_nobody_means_is_refused() -> None:
    """The codec rejects every near miss of a command, a stop or a release."""
    for text in (row(COMMAND | other) for other in NO_COMMANDS):
        with pytest.raises(ProtocolError):
            parse_drive(text)
    for text in (*NO_STOPS, *(json.dumps(RELEASE | other) for other in no_releases(RELEASE))):
        with pytest.raises(ProtocolError):
            parse_state(text)
