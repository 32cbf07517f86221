"""The eight errors of an untrusted channel (IEC 61784-3) against codec, gate and latch.

Each trace is a short piece of driving over a bad channel: pages send, the channel harms drive, stop
or release messages in one way, and the server's real codec, gate and latch receive them. An oracle
decides which motion is rightful: it knows what was really sent, by whom and when, but no sequence
numbers or timestamps.

DTLS, which carries every data channel (RFC 8831), protects a record's integrity and authenticity;
here an AEAD of the same kind replaces it, with one key per connection. The gate and the latch must
handle what gets through, and everything that a faulty page may send.

``WAX_TRACES=100000`` runs the full matrix in some minutes.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import pytest
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from tests.bad_channel import ERRORS, Tally, run
from tests.control.rules import RULES, VOUCHED
from tests.control.velocity import is_same

from wax.control import gate, stop_latch
from wax.control.beats import Beats
from wax.control.command_freshness import CALM_HELD_S
from wax.control.reasons import Hold
from wax.control.stop_latch import StopLatch
from wax.control.turn_view import TurnView
from wax.driver.interface import STANDSTILL, Twist
from wax.errors import ProtocolError
from wax.protocol import messages
from wax.sentence import says
from wax.session.viewer import command_of

if TYPE_CHECKING:
    import random

    from wax.control.gate import Setpoint

KINDS: Final = ("drive", "stop", "release")
CELLS: Final = tuple((error, kind) for error in (*ERRORS, "wrong address") for kind in KINDS)

ADA, BOB, STRANGER = 1, 2, 3
KEYS: Final = {one: AESGCM(bytes([one] * 16)) for one in (ADA, BOB, STRANGER)}
CHANNEL: Final = {"drive": "drive", "stop": "state", "release": "state"}
_TICKS: Final = 32
_RELEASED: Final = (0.0, 0.0, 0.0)
ROUNDING_S: Final = 1e-4
"""Timestamps have a resolution of 0.1 ms on the wire."""


@dataclass(frozen=True)
class Sent:
    """What somebody really sent: the truth that only the oracle knows."""

    kind: str
    sender: int
    sent_s: float
    turn: int = 0
    input: tuple[float, float, float] = _RELEASED
    held: bool = False
    pan: float | None = None
    stop: int = 0
    beat: str | None = None


@dataclass(frozen=True)
class Record:
    """A record from the channel, and its connection's owner; `truth` is None for a forged one."""

    due_s: float
    link: int
    channel: str
    data: bytes
    truth: Sent | None


def text_of(sent: Sent, seq: int) -> str:
    """Return what a page writes on the wire."""
    now_ms = round(sent.sent_s * 1000, 1)
    if sent.kind == "drive":
        axes = {} if sent.pan is None else {"pan": sent.pan}
        seen_ms = now_ms - 50.0
        linear, angular, lateral = sent.input
        hands = [linear, angular, sent.held, "fast"]
        row = ["drive", seq, sent.turn, now_ms, *hands, seen_ms, axes, sent.beat]
        return json.dumps([*row, lateral] if lateral else row)
    if sent.kind == "stop":
        return '{"type":"stop"}'
    release = {"type": "release", "stop": sent.stop, "sent_server_ms": now_ms}
    return json.dumps(release | {"beat": sent.beat})


def seal(rng: random.Random, key: int, channel: str, text: str) -> bytes:
    nonce = rng.randbytes(12)
    return nonce + KEYS[key].encrypt(nonce, text.encode(), channel.encode())


class Channel:
    """Carries records, and does one kind of harm to one kind of message."""

    def __init__(self, rng: random.Random, cell: tuple[str, str], tally: Tally) -> None:
        self.rng, self.cell, self.tally = rng, cell, tally
        self.delay_s = rng.choice([0.0, 0.02, 0.06, 0.2])
        # The delay varies per record, or is the same for all from the start.
        self.step_s = (
            rng.choice([0.3, 1.0, 2.2]) if cell[0] == "delay" and rng.random() < 0.5 else None
        )
        self.harmed_share = 0.4 if self.step_s is None else 1.0
        self.operator = ADA
        self.under_way: list[Record] = []

    def send(self, sent: Sent, seq: int) -> None:
        """Carry a message, and harm it if it is of the kind that this trace harms."""
        error, kind = self.cell
        if sent.kind != kind or self.rng.random() > self.harmed_share:
            error = self.rng.choice(ERRORS) if self.rng.random() < 0.03 else "none"
        text, channel = text_of(sent, seq), CHANNEL[sent.kind]
        record = Record(
            sent.sent_s + self.delay_s,
            sent.sender,
            channel,
            seal(self.rng, sent.sender, channel, text),
            sent,
        )
        self.under_way += self._harmed(error, record, sent, seq)
        if error != "none":
            self.tally.injected[error, sent.kind] += 1

    def due(self, now_s: float) -> list[Record]:
        """Return the records that have arrived by now, in order of arrival."""
        arrived = sorted((r for r in self.under_way if r.due_s <= now_s), key=lambda r: r.due_s)
        self.under_way = [r for r in self.under_way if r.due_s > now_s]
        return arrived

    def _harmed(self, error: str, record: Record, sent: Sent, seq: int) -> list[Record]:
        """Return the records that the channel delivers instead of one record."""
        rng = self.rng
        carried = [record]
        match error:
            case "corruption":
                carried = [replace(record, data=self._damaged(record.data), truth=None)]
            case "repetition":
                again_s = (rng.choice([0.0, 0.02, 0.1]), rng.uniform(0.2, 3.0))
                carried += [_later(record, by_s) for by_s in again_s]
            case "wrong order":
                carried = [_later(record, rng.uniform(0.0, 0.14))]
            case "loss":
                carried = []
            case "delay":
                carried = [_later(record, self.step_s or rng.uniform(0.1, 4.0))]
            case "insertion":
                carried += [self._inserted(record, sent, seq)]
            case "masquerade":
                carried = [self._disguised(record, sent, seq)]
            case "wrong address":
                carried = [self._misdirected(record, sent, seq)]
        return carried

    def _damaged(self, data: bytes) -> bytes:
        damaged = bytearray(data)
        for bit in self.rng.sample(range(8 * len(data)), self.rng.randint(1, 3)):
            damaged[bit // 8] ^= 1 << bit % 8
        cut = self.rng.randrange(len(damaged)) if self.rng.random() < 0.2 else len(damaged)
        return bytes(damaged[:cut])

    def _inserted(self, record: Record, sent: Sent, seq: int) -> Record:
        """Make a record that nobody sent: noise, clear text, or a faulty page's message."""
        text = text_of(sent, seq + 1)
        data = self.rng.choice(
            [
                self.rng.randbytes(60),
                text.encode(),
                seal(self.rng, STRANGER, record.channel, text),
                seal(self.rng, sent.sender, record.channel, self.rng.choice(_broken(sent, text))),
            ]
        )
        return replace(record, data=data, truth=None)

    def _disguised(self, record: Record, sent: Sent, seq: int) -> Record:
        """Make a stranger send it on the sender's connection, or another viewer on their own."""
        text = text_of(sent, seq)
        if sent.kind == "stop" or sent.sender != self.operator or self.rng.random() < 0.5:
            data = seal(self.rng, STRANGER, record.channel, text)
            return replace(record, data=data, truth=None)
        other = _other(sent.sender)
        data = seal(self.rng, other, record.channel, text)
        # It quotes a beat that they were never sent, which releases nothing, whoever drives then.
        truth = None if sent.kind == "release" else replace(sent, sender=other)
        return replace(record, link=other, data=data, truth=truth)

    def _misdirected(self, record: Record, sent: Sent, seq: int) -> Record:
        """Deliver it on another connection, on the other channel, or for another turn or stop."""
        wrong = "state" if record.channel == "drive" else "drive"
        match self.rng.randrange(3 if sent.kind == "stop" else 4):
            case 0:
                return replace(record, link=_other(sent.sender), truth=None)
            case 1:
                return replace(record, channel=wrong, truth=None)
            case 2:
                data = seal(self.rng, sent.sender, wrong, text_of(sent, seq))
                return replace(record, channel=wrong, data=data, truth=None)
            case _:
                by = self.rng.choice([-1, 1])
                elsewhere = replace(sent, turn=max(0, sent.turn + by), stop=max(0, sent.stop + by))
                data = seal(self.rng, sent.sender, record.channel, text_of(elsewhere, seq))
                return replace(record, data=data, truth=elsewhere)


def _later(record: Record, by_s: float) -> Record:
    return replace(record, due_s=record.due_s + by_s)


def _other(viewer: int) -> int:
    return BOB if viewer == ADA else ADA


def _broken(sent: Sent, text: str) -> list[str]:
    """Return an invalid variant of the message."""
    if sent.kind == "stop":
        return ['{"type":"stop"', '{"type":"stop","now":1}', '["stop"]', '{"type":"Stop"}']
    good, stamp = json.loads(text), str(round(sent.sent_s * 1000, 1))
    if sent.kind == "release":
        named = [{**good, "now": 1}, {**good, "stop": str(sent.stop)}, {**good, "stop": -1}]
        return [text[:-1], text.replace(stamp, "NaN"), *map(json.dumps, named)]
    rows = [
        [*good[:11], 0, 0],
        [*good[:11], 1.5],
        [*good[:4], 1.5, *good[5:]],
        [*good[:4], "1", *good[5:]],
        [*good[:6], 1, *good[7:]],
        [*good[:9], {"pan": 2.0}, *good[10:]],
        [*good[:10], 7, *good[11:]],
    ]
    return [text[:-1], text.replace(stamp, "Infinity"), *map(json.dumps, rows)]


class Server:
    """Codec, gate and latch, connected as in the server."""

    def __init__(self, turn: TurnView, now_s: float) -> None:
        self.turn, self.latch = turn, StopLatch()
        self.gate = gate.begin(turn.number, now_s)
        self.beats = {viewer: Beats() for viewer in (ADA, BOB)}

    def begin(self, turn: TurnView, now_s: float) -> None:
        self.turn, self.gate = turn, gate.begin(turn.number, now_s)

    def receive(self, record: Record, now_s: float) -> str:
        """Handle a record; return the outcome."""
        key, channel = KEYS[record.link], record.channel.encode()
        try:
            text = key.decrypt(record.data[:12], record.data[12:], channel)
            if record.channel == "drive":
                message = messages.parse_drive(text)
            else:
                return self._state(messages.parse_state(text), record.link, now_s)
        except (InvalidTag, ValueError):  # of DTLS: no record of this connection
            return "not authentic"
        except ProtocolError:
            return "refused by the codec"
        if not isinstance(message, messages.Drive):
            return "no command"
        seen_ms = message.seen_server_ms
        seen_s = None if seen_ms is None else seen_ms / 1000
        self.gate, refusal = gate.accept(
            self.gate,
            record.link,
            command_of(message, self.beats[record.link].sent_s(message.beat), seen_s),
            turn=self.turn,
            now_s=now_s,
            rules=RULES,
        )
        return "accepted" if refusal is None else refusal.name

    def _state(self, message: messages.StateIn, viewer: int, now_s: float) -> str:
        match message:
            case messages.Stop():
                self.latch = stop_latch.press(self.latch, says(str(viewer)), now_s)
                return "stopped"
            case messages.Release():
                heard_s = self.beats[viewer].sent_s(message.beat)
                sent_s = min(message.sent_server_ms / 1000, heard_s + CALM_HELD_S)
                self.latch, refusal = stop_latch.release(
                    self.latch, viewer, message.stop, sent_s, turn=self.turn, now_s=now_s
                )
                if refusal is not None:
                    return refusal.name
                self.gate = gate.require_neutral(self.gate, now_s, Hold.STOPPED)
                return "released"
            case _:
                return "no command"

    def beat(self, now_s: float) -> Setpoint:
        """Decide again; call it on every tick."""
        self.gate, setpoint = gate.decide(self.gate, self.turn, self.latch.stop, now_s, RULES)
        return setpoint


class Oracle:
    """Knows what was really sent and has really arrived, and decides what is rightful."""

    def __init__(self, operator: int, turn: int, now_s: float, ttl_s: float) -> None:
        self.ttl_s = ttl_s
        self.stops = 0
        self.is_stopped = False
        self.pressed_s = 0.0
        self.begin(operator, turn, now_s)

    def begin(self, operator: int, turn: int, now_s: float) -> None:
        self.operator, self.turn, self.hold_s = operator, turn, now_s
        self.heard: list[Sent] = []

    def hear(self, truth: Sent | None, now_s: float) -> None:
        """Record a message that arrived as it was sent."""
        if truth is None:
            return
        age_s = now_s - truth.sent_s
        match truth.kind:
            case "stop":
                self.stops += not self.is_stopped
                self.is_stopped, self.pressed_s = True, now_s
            case "release":
                if (
                    self.is_stopped
                    and truth.sender == self.operator
                    and truth.stop == self.stops
                    and truth.beat
                    is not None  # who has heard none may still be as old as they like
                    and age_s <= 2.0
                    and truth.sent_s >= self.pressed_s - ROUNDING_S
                ):
                    self.is_stopped, self.hold_s = False, now_s
            case _:
                if truth.sender == self.operator and truth.turn == self.turn:
                    self.heard.append(truth)

    def rightful(self, now_s: float) -> Sent | None:
        """Return the one command that the robot may follow now."""
        if self.is_stopped:
            return None
        since = [s for s in self.heard if s.sent_s >= self.hold_s - ROUNDING_S]
        newest = max(since, key=lambda s: s.sent_s, default=None)
        if newest is None or now_s - newest.sent_s > self.ttl_s + ROUNDING_S:
            return None
        let_go = any(s.input == _RELEASED and not s.held for s in since)
        return newest if let_go else None


class Trace:
    """A short piece of driving over a channel that does one kind of harm."""

    def __init__(self, rng: random.Random, cell: tuple[str, str], tally: Tally) -> None:
        self.rng, self.cell, self.tally = rng, cell, tally
        self.channel = Channel(rng, cell, tally)
        self.now_s = 1000.0
        self.tick_s = rng.choice([0.02, 0.02, 0.033, 0.05, 0.1, 0.1])
        self.stop_chance = 0.01 if cell[1] == "drive" else 0.1
        self.number, self.operator = 5, ADA
        self.server = Server(self._turn(), self.now_s)
        self.oracle = Oracle(self.operator, self.number, self.now_s, 0.15 + self.channel.delay_s)
        self.seqs: Counter[int] = Counter()
        self.believed_turn = self.number
        self.input: tuple[float, float, float] = _RELEASED
        self.held = False
        self.pan: float | None = None
        self.beats: dict[int, list[tuple[float, str]]] = {ADA: [], BOB: []}

    def run(self) -> str | None:
        """Play the trace; return what went wrong, if anything did."""
        for _ in range(_TICKS):
            self.now_s += self.tick_s
            self._send_beats()
            if self.rng.random() < 0.02:
                self._hand_over()
            self._pages_speak()
            for record in self.channel.due(self.now_s):
                self.tally.happened[self.server.receive(record, self.now_s)] += 1
                self.oracle.hear(record.truth, self.now_s)
                if (self.server.latch.stop is not None) is not self.oracle.is_stopped:
                    return f"stop or release at {self.now_s:.3f} by {record.truth}"
            setpoint = self.server.beat(self.now_s)
            fault = judged(setpoint, self.oracle.rightful(self.now_s), self.tally)
            if fault is not None:
                return f"{fault} at {self.now_s:.3f}"
        return None

    def _turn(self) -> TurnView:
        one_way_s = self.channel.delay_s
        return TurnView(
            self.number,
            self.operator,
            present=True,
            one_way_s=one_way_s,
            sees=True,
            picture=VOUCHED,
        )

    def _hand_over(self) -> None:
        self.number, self.operator = self.number + 1, _other(self.operator)
        self.channel.operator = self.operator
        self.server.begin(self._turn(), self.now_s)
        self.oracle.begin(self.operator, self.number, self.now_s)

    def _send_beats(self) -> None:
        for viewer, beats in self.server.beats.items():
            if beats.is_due(self.now_s, is_thin=False):
                heard_s = self.now_s + self.channel.delay_s
                self.beats[viewer].append((heard_s, beats.send(self.now_s)))

    def _heard(self, viewer: int, by_s: float) -> str | None:
        heard = (word for heard_s, word in reversed(self.beats[viewer]) if heard_s <= by_s)
        return next(heard, None)

    def _pages_speak(self) -> None:
        """Send the pages' messages, at random times since the last tick."""
        rng = self.rng
        self._move_hands()
        sent_s = self.now_s - self.tick_s * rng.uniform(0.1, 0.9)
        for sender in (ADA, BOB):
            if sender == self.operator or rng.random() < 0.3:
                self.seqs[sender] += 1
                turn = self.believed_turn
                meant = Sent("drive", sender, sent_s, turn, self.input, self.held, self.pan)
                meant = replace(meant, beat=self._heard(sender, sent_s))
                self.channel.send(meant, self.seqs[sender])
        stop = self.server.latch.stop
        if rng.random() < (self.stop_chance if stop is None else self.stop_chance / 10):
            self.channel.send(Sent("stop", rng.choice([ADA, BOB]), sent_s), 0)
        if stop is not None and rng.random() < 0.35:
            releaser = self.operator if rng.random() < 0.9 else rng.choice([ADA, BOB])
            beat = self._heard(releaser, sent_s)
            self.channel.send(Sent("release", releaser, sent_s, stop=stop.number, beat=beat), 0)

    def _move_hands(self) -> None:
        rng = self.rng
        if rng.random() < 0.5:
            self.believed_turn = self.number  # the news of a hand-over take their time
        if rng.random() < 0.2:
            self.held = rng.random() < 0.65
            linear, angular, lateral = (round(rng.uniform(-1, 1), 3) for _ in range(3))
            shares = (linear, angular, rng.choice([0.0, lateral]))
            self.input = shares if self.held else _RELEASED
            self.pan = rng.choice([None, round(rng.uniform(-1, 1), 2)])
            if rng.random() < 0.05:
                self.held = not self.held  # a page in disorder


def judged(setpoint: Setpoint, rightful: Sent | None, tally: Tally) -> str | None:
    """Return what is wrong with the set-point that the robot gets, if anything."""
    if setpoint.twist == STANDSTILL and not setpoint.axes:
        return None
    if rightful is None:
        return f"motion without right: {setpoint}"
    limits = RULES.limits
    twist, axes = STANDSTILL, {}
    if rightful.held:
        linear, angular, lateral = rightful.input
        over = max(1.0, abs(complex(linear, lateral)))
        twist = Twist(
            linear / over * limits.linear_mps,
            angular * limits.angular_rps,
            lateral / over * limits.lateral_mps,
        )
        axes = {} if rightful.pan is None else {"pan": rightful.pan}
    if not is_same(setpoint.twist, twist) or dict(setpoint.axes) != axes:
        return f"another motion than was asked for: {setpoint} instead of {rightful}"
    tally.happened["moved"] += setpoint.twist != STANDSTILL
    tally.happened["sideways"] += setpoint.twist.lateral_mps != 0.0
    tally.happened["panned"] += bool(setpoint.axes)
    return None


@pytest.mark.timeout(3600)
def test_nothing_wrong_is_ever_executed() -> None:
    """No trace leads to a motion, a stop or a release that nobody has rightfully sent."""
    tally = run(CELLS, Trace, 2000, seed=5)
    traces = tally.traces
    # The test is not vacuous: each refusal occurred, and the robot was driven.
    for what in ("moved", "sideways", "panned", "accepted", "stopped", "released", "not authentic"):
        assert tally.happened[what] >= traces // 4, what
    for what in ("NOT_YOUR_TURN", "OTHER_TURN", "OUT_OF_ORDER", "OTHER_STOP", "NOT_YOUR_STOP"):
        assert tally.happened[what] >= traces // 20, what
    for what in ("TOO_OLD", "refused by the codec"):
        assert tally.happened[what] >= traces // 50, what
    assert tally.happened["RELEASED_LATE"] >= traces // 1000
