"""A hand control and a server over bad lines (IEC 61784-3) against codec, rules and watchdog.

In each trace of a few seconds an operator drives through a server, and a person aboard at times
takes over, lets go, presses Stop and resumes; a channel harms the bytes of one of the two in one
way. The real decoder, rules and watchdog are compared with an oracle, which knows what was really
sent and has really arrived, and decides whose motion is rightful. It knows nothing of numbers,
checksums, modes, epochs or holds.

``WAX_TRACES=100000`` runs the full matrix in some minutes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import pytest
from tests.bad_channel import ERRORS, Tally, run

from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.control.local_hand import HandRules
from wax.driver.hand import HandReading
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.errors import ProtocolError
from wax.robot.hand import line
from wax.robot.process.driver_watchdog import Apply, DriverWatchdog, StopDriver
from wax.robot.process.hand_watchdog import HandWatchdog
from wax.robot.process.pipe_messages import Bye, Halt, Move, decode_message, encode
from wax.robot.serial import frames

if TYPE_CHECKING:
    import random

    from wax.robot.process.driver_watchdog import Call

LINES: Final = ("hand", "server")
CELLS: Final = tuple((error, which) for error in ERRORS for which in LINES)

LIMITS: Final = Limits(linear_mps=0.6, angular_rps=1.5, lateral_mps=0.6)
SILENCE_S: Final = 0.12
RULES: Final = HandRules.of(
    LocalSettings(source="serial", pause_s=0.5, max_fraction=0.5, silence_ms=150),
    RobotSettings(),
    0.02,
)
_TICK_S: Final = 0.01
_TICKS: Final = 200
_NEAR: Final = 1e-6
_BEAT_S: Final = 0.02 + _NEAR


@dataclass(frozen=True)
class Record:
    """Bytes from a line, and the message really sent; None if nobody sent it."""

    due_s: float
    data: bytes
    truth: HandReading | Move | Halt | None


class Channel:
    """One line, which does one kind of harm, or none."""

    def __init__(self, rng: random.Random, which: str, error: str, tally: Tally) -> None:
        self.rng, self.which, self.error, self.tally = rng, which, error, tally
        self.under_way: list[Record] = []
        self.mute_until_s = 0.0

    def send(self, data: bytes, truth: HandReading | Move | Halt, now_s: float) -> None:
        record = Record(now_s, data, truth)
        if self.error == "none" or self.rng.random() > 0.2:
            self.under_way.append(record)
            return
        self.tally.injected[self.error, self.which] += 1
        self.under_way += self._harmed(record, now_s)

    def due(self, now_s: float) -> list[Record]:
        """Return what has arrived by now; a stalled line delivers everything at its end."""
        if now_s < self.mute_until_s:
            return []
        arrived = sorted((r for r in self.under_way if r.due_s <= now_s), key=lambda r: r.due_s)
        self.under_way = [r for r in self.under_way if r.due_s > now_s]
        return arrived

    def _harmed(self, record: Record, now_s: float) -> list[Record]:
        rng, carried = self.rng, [record]
        match self.error:
            case "corruption":
                carried = [replace(record, data=self._damaged(record.data), truth=None)]
            case "repetition":
                again_s = now_s + rng.choice([0.0, 0.02, 0.3])
                carried += [replace(record, due_s=again_s, truth=None)]
            case "wrong order":
                carried = [replace(record, due_s=now_s + rng.uniform(0.02, 0.1))]
            case "loss":
                carried = []
            case "delay":
                self.mute_until_s = max(self.mute_until_s, now_s + rng.uniform(0.05, 0.4))
            case "insertion":
                carried += [Record(now_s, self._noise(), None)]
            case "masquerade":
                carried += [Record(now_s, self._strangers(record), None)]
        return carried

    def _damaged(self, data: bytes) -> bytes:
        if self.which == "server":
            cut = self.rng.randrange(1, len(data) - 1)
            return data[:cut] + b"\n"
        damaged = bytearray(data)
        for bit in self.rng.sample(range(8 * len(data)), self.rng.randint(1, 3)):
            damaged[bit // 8] ^= 1 << bit % 8
        return bytes(damaged)

    def _noise(self) -> bytes:
        noise = self.rng.randbytes(self.rng.randint(1, 30))
        return noise if self.which == "hand" else noise.replace(b"\n", b".") + b"\n"

    def _strangers(self, record: Record) -> bytes:
        """Return foreign messages: a robot board's, or those of an operator whose turn is over."""
        if self.which == "hand":
            report = frames.ReportBody(7000, 0, 1, 2, 0, 0)
            return frames.encode(frames.Frame(report), self.rng.randint(1, 65534))
        assert isinstance(record.truth, Move | Halt)
        move = Move(
            sequence=record.truth.sequence + 1,
            sent_s=record.truth.sent_s,
            turn=record.truth.turn - 1,
            linear_mps=0.11,
            angular_rps=0.0,
        )
        return encode(move)


class Oracle:
    """Decides who may move the robot, from what was really sent and has arrived."""

    def __init__(self) -> None:
        self.newest: HandReading | None = None
        self.recent: list[tuple[HandReading, float]] = []
        """Those that were the newest at the last beat, which the driver may still follow, and until
        when they were: one that comes late may have been it for longer than a beat."""
        self.not_free_s = 1000.0
        """When the robot was last the person's, or nobody's."""
        self.is_stopped = False
        self.was_at_rest = False
        self.turn = 0
        self.newest_said: Move | Halt | None = None
        self.neutral_s = -math.inf
        """When the operator of this turn last asked for standstill."""

    def feel(self, reading: HandReading, now_s: float) -> None:
        """Record what the person really did."""
        self.look(now_s)
        before, self.newest = self.newest, reading
        self.recent = [one for one in self.recent if now_s - one[1] <= _BEAT_S]
        if before is not None:
            self.recent.append((before, now_s))
        goes_on = reading.ask == "go_on" and before is not None and before.ask != "go_on"
        is_touched = touches(reading)
        self.is_stopped = reading.stop or (self.is_stopped and not (goes_on and not is_touched))
        self.was_at_rest = (self.was_at_rest or not is_touched) and not self.is_stopped
        if is_touched or self.is_stopped:
            self.not_free_s = now_s

    def look(self, now_s: float) -> None:
        """Let time pass: a silent control counts as lost."""
        if self.newest is not None and now_s - self.newest.at_s > RULES.silence_s + _NEAR:
            self.newest, self.was_at_rest = None, False
        if self.newest is None or self.is_stopped:
            self.not_free_s = now_s

    def listen(self, said: Move | Halt) -> None:
        """Record what the server really sent."""
        if said.turn < self.turn:
            return
        if said.turn > self.turn:
            self.turn, self.newest_said, self.neutral_s = said.turn, None, -math.inf
        if self.newest_said is None or said.sequence > self.newest_said.sequence:
            self.newest_said = said
        if isinstance(said, Move) and _numbers(said) == (0.0, 0.0, 0.0):
            self.neutral_s = max(self.neutral_s, said.sent_s)

    def owner(self, twist: Twist, now_s: float) -> str | None:
        """Return whose motion this may be, None if nobody's."""
        self.look(now_s)
        if self.newest is None or self.is_stopped:
            return None
        if touches(self.newest):
            beat = [one for one, until_s in self.recent if now_s - until_s <= _BEAT_S]
            follows = self.was_at_rest and any(_follows(twist, one) for one in [*beat, self.newest])
            return "person" if follows else None
        return "operator" if self._is_operators(twist, now_s) else None

    def _is_operators(self, twist: Twist, now_s: float) -> bool:
        since_s, said = self.not_free_s + RULES.pause_s - _NEAR, self.newest_said
        if not isinstance(said, Move) or now_s < since_s:
            return False
        is_asked = _numbers(said) == _numbers(twist)
        is_fresh = now_s - said.sent_s <= SILENCE_S + _NEAR
        return is_asked and is_fresh and min(self.neutral_s, said.sent_s) >= since_s


def touches(reading: HandReading) -> bool:
    """Whether a hand is on the control, by the manual's definition."""
    stick = (reading.linear, reading.angular, reading.lateral)
    return reading.is_held or max(map(abs, stick)) > RULES.dead_zone


def _numbers(twist: Twist | Move) -> tuple[float, float, float]:
    return twist.linear_mps, twist.angular_rps, twist.lateral_mps


def _follows(twist: Twist, reading: HandReading) -> bool:
    """Whether a twist goes where the stick points, or on the way there, and no faster."""
    if not touches(reading):
        return False
    limits = (LIMITS.linear_mps, LIMITS.angular_rps, LIMITS.lateral_mps)
    most = [limit * RULES.max_fraction for limit in limits]
    stick = (reading.linear, reading.angular, reading.lateral)
    parts = zip(_numbers(twist), stick, most, strict=True)
    return all(_is_on_its_way(part, stick, fast) for part, stick, fast in parts)


def _is_on_its_way(part: float, stick: float, most: float) -> bool:
    if abs(stick) <= RULES.dead_zone:
        return part == 0.0
    return part * stick >= 0.0 and abs(part) <= most + _NEAR


class Trace:
    """A few seconds in which both drive, over two lines of which one does harm."""

    def __init__(self, rng: random.Random, cell: tuple[str, str], tally: Tally) -> None:
        self.rng, self.tally = rng, tally
        error, which = cell
        self.hand = Channel(rng, "hand", error if which == "hand" else "none", tally)
        self.server = Channel(rng, "server", error if which == "server" else "none", tally)
        self.watchdog = HandWatchdog(DriverWatchdog(LIMITS, SILENCE_S), RULES)
        self.decoder = line.HandDecoder()
        self.oracle = Oracle()
        self.arrived: list[HandReading] = []
        """What was meant and has arrived, until it is read."""
        self.now_s = 1000.0
        self.number = 0
        self.sequence = 0
        self.turn = 3
        self.doing = HandReading(0.0)
        self.until_s = self.now_s + rng.choice([0.0, 0.8])
        self.asked = STANDSTILL
        self.twist = STANDSTILL
        self.server_dies_s = rng.choice([math.inf, math.inf, self.now_s + rng.uniform(1.0, 2.0)])

    def run(self) -> str | None:
        """Play the trace; return what went wrong, if anything did."""
        for tick in range(_TICKS):
            self.now_s += _TICK_S
            self._person_acts(tick)
            self._server_speaks(tick)
            self._feel()
            self._do(self.watchdog.tick(self.now_s))
            self._listen()
            if tick % 2 == 0:
                self._do(self.watchdog.repeat(self.now_s))
            fault = self._judge()
            if fault is not None:
                return f"{fault} at {self.now_s:.2f}"
        return None

    def _judge(self) -> str | None:
        if self.twist.is_zero:
            return None
        owner = self.oracle.owner(self.twist, self.now_s)
        if owner is None:
            return f"motion without right: {self.twist}, newest {self.oracle.newest}"
        self.tally.happened[owner] += 1
        return None

    def _feel(self) -> None:
        """Let all that has arrived from the control count, before the server."""
        found: list[HandReading] = []
        for record in self.hand.due(self.now_s):
            if isinstance(record.truth, HandReading):
                self.arrived.append(replace(record.truth, at_s=self.now_s))
            for reading in self.decoder.feed(record.data, self.now_s):
                found.append(reading)
                self._tell_oracle(reading)
        self._do(self.watchdog.handle_readings(found, self.now_s))

    def _tell_oracle(self, reading: HandReading) -> None:
        """Let it hear what was read if it was meant; anything else is the line's own."""
        meant = [replace(one, at_s=self.now_s) for one in self.arrived]
        if reading in meant:
            del self.arrived[: meant.index(reading) + 1]
            self.oracle.feel(reading, self.now_s)
        elif reading.stop and self.doing.stop:
            # A Stop counts even if the rest of its frame is damaged.
            self.oracle.feel(replace(self.doing, at_s=self.now_s), self.now_s)
        else:
            self.tally.happened["forged"] += 1

    def _listen(self) -> None:
        for record in self.server.due(self.now_s):
            try:
                message = decode_message(record.data.rstrip(b"\n"))
            except ProtocolError:
                self.tally.happened["garbage"] += 1
                self._do(self.watchdog.handle_invalid(self.now_s))
                continue
            if isinstance(record.truth, Move | Halt):
                self.oracle.listen(record.truth)
            assert not isinstance(message, Bye)
            self._do(self.watchdog.handle(message, self.now_s))

    def _do(self, calls: tuple[Call, ...]) -> None:
        for call in calls:
            if isinstance(call, Apply):
                self.twist = call.twist
            elif isinstance(call, StopDriver):
                self.twist = STANDSTILL

    def _person_acts(self, tick: int) -> None:
        """Send a frame each 20 ms; do something else now and then."""
        rng = self.rng
        if self.now_s >= self.until_s:
            self.until_s = self.now_s + rng.choice([0.05, 0.1, 0.3, 0.9])
            self.doing = rng.choices(
                [
                    HandReading(0.0),
                    HandReading(0.0, _share(rng), _share(rng)),
                    HandReading(0.0, is_held=True),
                    HandReading(0.0, stop=True),
                    HandReading(0.0, ask="go_on"),
                    HandReading(0.0, ask="wait"),
                ],
                weights=[10, 5, 1, 1, 3, 1],
            )[0]
            self.tally.happened["stop"] += self.doing.stop
        if tick % 2 == 0:
            self.number += 1
            self.hand.send(
                line.encode(self.doing, self.number, has_aside=True), self.doing, self.now_s
            )

    def _server_speaks(self, tick: int) -> None:
        """Ask for something else now and then, as an operator through a gate does."""
        rng = self.rng
        if self.now_s >= self.server_dies_s or tick % 2 == 0:
            return
        if rng.random() < 0.06:
            self.asked = (
                STANDSTILL
                if rng.random() < 0.5
                else Twist(round(rng.uniform(0.2, 0.4), 3), lateral_mps=rng.choice([0.0, 0.3]))
            )
        self.turn += rng.random() < 0.004
        self.sequence += 1
        said: Move | Halt
        if rng.random() < 0.005:
            said = Halt(sequence=self.sequence, sent_s=self.now_s, turn=self.turn)
        else:
            said = Move(
                sequence=self.sequence,
                sent_s=self.now_s,
                turn=self.turn,
                linear_mps=self.asked.linear_mps,
                angular_rps=self.asked.angular_rps,
                lateral_mps=self.asked.lateral_mps,
            )
        self.server.send(encode(said), said, self.now_s)


def _share(rng: random.Random) -> float:
    return round(rng.uniform(-1.0, 1.0), 2)


@pytest.mark.timeout(7200)
def test_nothing_moves_against_the_person_aboard() -> None:
    """In no trace is there a motion that is neither the person's nor a permitted operator's."""
    tally = run(CELLS, Trace, 600, seed=6)
    traces = tally.traces
    # It was no idle talk: both have driven.
    for what in ("person", "operator"):
        assert tally.happened[what] >= traces // 4, what
    assert tally.happened["stop"] >= traces // 10
    assert tally.happened["forged"] == 0
    assert tally.happened["garbage"] >= traces // 20
