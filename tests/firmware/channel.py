"""A line that does to frames what a line can do (IEC 61784-3), and an oracle for what may happen.

The oracle judges by what was really sent, when and by whom; it never reads a byte of a frame.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from tests.firmware.core import Core, Kind, Settings, Verdict

from wax.robot.serial.frames import (
    AxisBody,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    StopBody,
    encode,
)

if TYPE_CHECKING:
    import ctypes
    from random import Random

    from wax.robot.serial.frames import Body

ERRORS: Final = (
    "none", "corruption", "repetition", "wrong order", "loss", "delay", "insertion",
    "masquerade", "wrong address", "old turn", "repeated with its hello",
)  # fmt: skip
TTL_MS: Final = 200
PERIOD_MS: Final = 20
ARM_MM: Final = 200
MOTION: Final = (DriveBody, MoveBody, AxisBody)
# In each step of the clock a wheel can reach any speed that is commanded here.
BRISK: Final = {
    kind: Settings(acceleration_mmps2=65_535, braking_mmps2=65_535, kind=kind, arm_mm=ARM_MM)
    for kind in Kind
}


@dataclass(frozen=True, slots=True)
class Said:
    """A frame as its sender meant it: `order` rises with every frame of the server."""

    order: int
    at_ms: int
    session: int
    frame: Frame
    genuine: bool = True


@dataclass(frozen=True, slots=True)
class Arrival:
    """Bytes at the robot's end. `damage` is why they differ from what was sent, if they do."""

    at_ms: int
    wire: bytes
    said: Said | None
    damaged: bool = False


class Server:
    """Sends what a server sends: a hello, then drives, axes and stops of rising turns."""

    def __init__(self, random: Random, clock_ms: int, delay_up_ms: int, kind: Kind) -> None:
        self._random = random
        self._kind = kind
        self._clock_ms = clock_ms
        self._delay_up_ms = delay_up_ms
        self._order = 0
        self._turn = 1
        self.session = 0

    def hello(self, at_ms: int) -> list[Said]:
        self.session = self._random.randint(1, 65_534)
        return [
            self._say(HelloBody(self.session), at_ms, turn=0),
            self._say(StopBody(), at_ms, turn=0),
        ]

    def speak(self, at_ms: int) -> list[Said]:
        random = self._random
        if random.random() < 0.06:
            self._turn += random.randint(1, 3)
            return [self._say(StopBody(), at_ms)]
        if random.random() < 0.1:
            return [self._say(StopBody(), at_ms)]
        said = [self._say(motion(random, self._kind), at_ms)]
        if random.random() < 0.1:
            said.append(self._say(AxisBody(random.randint(0, 3), random.randint(1, 10_000)), at_ms))
        return said

    def late_turn(self, at_ms: int) -> Said:
        """Send a motion of the previous turn, as a sender that does not know it is over."""
        return self._say(motion(self._random, self._kind), at_ms, turn=self._turn - 1)

    def _say(self, body: Body, at_ms: int, turn: int | None = None) -> Said:
        self._order += 1
        frame = Frame(
            body,
            sequence=self._order & 0xFFFF,
            turn=self._turn if turn is None else turn,
            ttl_ms=TTL_MS if isinstance(body, MOTION) else 0,
            time_ms=0
            if isinstance(body, HelloBody)
            else (self._clock_ms + at_ms - self._delay_up_ms) % 2**32,
        )
        return Said(self._order, at_ms, self.session, frame)


def motion(random: Random, kind: Kind) -> DriveBody | MoveBody:
    """Return a motion for this base, in which no wheel ever turns the other way.

    A base that moves sideways obeys drives, too.
    """
    if kind is Kind.SIDES:
        return DriveBody(random.randint(1, 60), random.randint(1, 60))
    ahead = random.randint(30, 40)
    if random.random() < 0.2:
        return DriveBody(ahead, ahead + random.randint(2, 10))
    return MoveBody(ahead, random.randint(-12, -1), random.randint(1, 60))


def stranger(random: Random, like: Frame, session: int) -> Said:
    """Return another sender's frame: it goes back, in a session that was never announced here."""
    body = DriveBody(-random.randint(1, 60), -random.randint(1, 60))
    frame = Frame(body, like.sequence + 1, like.turn + 1, TTL_MS, like.time_ms)
    return Said(0, 0, session, frame, genuine=False)


def corrupt(random: Random, wire: bytes) -> bytes:
    """Flip one to three bits, or some within 16 consecutive ones: what the CRC always detects."""
    bits = len(wire) * 8
    if random.random() < 0.5:
        flipped = random.sample(range(bits), random.randint(1, 3))
    else:
        start = random.randrange(bits - 16)
        flipped = [start, *(at for at in range(start + 1, start + 16) if random.random() < 0.5)]
    damaged = bytearray(wire)
    for bit in flipped:
        damaged[bit // 8] ^= 0x80 >> bit % 8
    return bytes(damaged)


@dataclass
class Trace:
    """What arrives, in the order of arrival, and the errors that the line has made."""

    clock_ms: int
    delay_up_ms: int
    kind: Kind = Kind.SIDES
    arrivals: list[Arrival] = field(default_factory=list)
    errors: Counter[str] = field(default_factory=Counter)

    @property
    def is_whole(self) -> bool:
        """Whether each frame ends where it should, so that none waits for bytes of the next."""
        return not any(arrival.damaged or arrival.said is None for arrival in self.arrivals)


def make_trace(random: Random, kind: Kind = Kind.SIDES) -> Trace:
    """Send some forty frames over a line that makes one kind of error, or sometimes every kind."""
    start_ms = random.choice([0, random.randrange(2**32), 2**32 - random.randint(0, 2000)])
    trace = Trace(start_ms, random.randint(0, 20), kind)
    server = Server(random, trace.clock_ms, trace.delay_up_ms, kind)
    kinds = [random.choice(ERRORS)] if random.random() < 0.7 else list(ERRORS)
    now_ms = 10
    line = Line(random, server)
    for said in server.hello(now_ms):
        trace.arrivals += line.carry("none", said, now_ms)
    for _ in range(random.randint(5, 40)):
        now_ms += PERIOD_MS + random.choice((0, 0, 0, 0, 0, 0, 100, 600))
        anew = random.random() < 0.04
        for said in server.hello(now_ms) if anew else server.speak(now_ms):
            error = random.choice(kinds) if random.random() < 0.4 else "none"
            trace.errors[error] += 1
            trace.arrivals += line.carry(error, said, now_ms)
    trace.arrivals.sort(key=lambda arrival: arrival.at_ms)
    return trace


class Line:
    """Carries frames, and makes the errors it is told to make."""

    def __init__(self, random: Random, server: Server) -> None:
        self._random = random
        self._server = server
        self._past: list[Said] = []

    def carry(self, kind: str, said: Said, now_ms: int) -> list[Arrival]:
        """Return what becomes of one frame that is sent now."""
        random = self._random
        self._past.append(said)
        soon_ms = now_ms + random.randint(0, 5)
        arrivals = [_arrival(said, soon_ms)]
        wire = arrivals[0].wire
        match kind:
            case "corruption":
                arrivals = [Arrival(soon_ms, corrupt(random, wire), said, damaged=True)]
            case "repetition":
                again = random.choice(self._past[-10:])
                arrivals.append(_arrival(again, soon_ms + random.choice((0, 1, 30, 150))))
            case "wrong order":
                arrivals = [_arrival(said, now_ms + random.randint(0, 3 * PERIOD_MS))]
            case "loss":
                arrivals = []
            case "delay":
                delay_ms = random.choice((100, 199, 200, 201, 230, 500, 70_000))
                arrivals = [_arrival(said, now_ms + delay_ms)]
            case "insertion":
                noise = random.randbytes(random.randint(1, 40))
                torn = wire[: random.randrange(len(wire))]
                arrivals.insert(0, Arrival(soon_ms, random.choice((noise, torn)), None))
            case "masquerade" | "wrong address":
                guess, next_one = random.randint(1, 65_534), said.session % 65_534 + 1
                session = guess if kind == "masquerade" else next_one
                arrivals.append(_arrival(stranger(random, said.frame, session), soon_ms + 1))
            case "old turn":
                arrivals.append(_arrival(self._server.late_turn(now_ms), soon_ms + 1))
            case "repeated with its hello":
                hellos = [one for one in self._past if isinstance(one.frame.body, HelloBody)]
                old = [random.choice(hellos), *self._past[-random.randint(1, 10) :]]
                arrivals += [_arrival(one, soon_ms + 1) for one in old]
        return arrivals


def _arrival(said: Said, at_ms: int) -> Arrival:
    return Arrival(at_ms, encode(said.frame, said.session), said)


class Oracle:
    """Knows what may be obeyed, and what the wheels may do, from who sent what and when."""

    def __init__(self, kind: Kind) -> None:
        self._kind = kind
        self._session: int | None = None
        self._hello_ms = 0
        self._newest = 0
        self._turn = 0
        self._wheels = self._still = (0,) * kind.wheels
        self._until_ms = math.inf

    def may(self, said: Said, now_ms: int) -> bool:
        """Whether this may be obeyed: a hello, this session's stop, or the newest motion in time.

        After a motion has expired, no other may begin before the next hello or stop.
        """
        if isinstance(said.frame.body, HelloBody):
            return True
        if isinstance(said.frame.body, StopBody):
            return said.session == self._session
        return (
            said.genuine
            and said.session == self._session
            and said.at_ms >= self._hello_ms
            and said.order > self._newest
            and said.frame.turn >= self._turn
            and now_ms - said.at_ms <= TTL_MS
            and now_ms < self._until_ms
        )

    def must(self, said: Said, now_ms: int, delay_up_ms: int) -> bool:
        """Whether this must be obeyed; for motion the server knows the time only as of a report."""
        if not isinstance(said.frame.body, MOTION):
            return self.may(said, now_ms)
        known_at_ms = said.at_ms - delay_up_ms
        in_time = known_at_ms >= self._hello_ms and now_ms - known_at_ms <= TTL_MS
        return in_time and self.may(said, now_ms)

    def took(self, said: Said, now_ms: int) -> None:
        body = said.frame.body
        if isinstance(body, HelloBody):
            self._session, self._hello_ms = body.session, now_ms
            self._newest, self._turn = said.order, 0
        else:
            self._newest = max(self._newest, said.order)
            self._turn = max(self._turn, said.frame.turn)
        if isinstance(body, DriveBody | MoveBody):
            self._wheels = wheels_for(self._kind, body)
            self._until_ms = now_ms + said.frame.ttl_ms
        elif not isinstance(body, AxisBody):
            self._wheels, self._until_ms = self._still, math.inf

    def wheels(self, now_ms: int) -> tuple[int, ...]:
        return self._wheels if now_ms < self._until_ms else self._still


def wheels_for(kind: Kind, body: DriveBody | MoveBody) -> tuple[int, ...]:
    """Return how fast each wheel turns, from where it stands and which way it rolls."""
    if isinstance(body, DriveBody):
        if kind is Kind.SIDES:
            return body.left_mmps, body.right_mmps
        ahead, aside = 500 * (body.left_mmps + body.right_mmps), 0
        spin = 500 * (body.right_mmps - body.left_mmps)
    else:
        ahead, aside = 1000 * body.linear_mmps, 1000 * body.lateral_mmps
        spin = body.angular_mradps * ARM_MM
    if kind is Kind.MECANUM:
        speeds = [
            ahead - rolls * aside + side * spin
            for rolls, side in ((1, -1), (-1, 1), (-1, -1), (1, 1))
        ]
    else:
        part = ahead * 866 // 1000
        speeds = [part - aside // 2 - spin, part + aside // 2 + spin, aside - spin]
    return tuple(int(speed / 1000) for speed in speeds)


def play(trace: Trace, core: ctypes.CDLL | None = None) -> Counter[str]:
    """Play a trace to a core; raises `AssertionError` at the first wrong execution.

    It counts drives that were accepted and refused, so that no test passes without any.
    """
    robot = Core(BRISK[trace.kind], trace.clock_ms, core)
    oracle = Oracle(trace.kind)
    meant = {arrival.said.frame: arrival.said for arrival in trace.arrivals if arrival.said}
    counts: Counter[str] = Counter()
    whole = trace.is_whole
    now_ms = 0
    for arrival in trace.arrivals:
        now_ms = _let_pass(robot, oracle, trace, now_ms, arrival.at_ms)
        said = arrival.said
        wanted = whole and said is not None and oracle.must(said, now_ms, trace.delay_up_ms)
        found = robot.hear(arrival.wire, trace.clock_ms + now_ms)
        for frame, verdict in found:
            _judge(oracle, meant.get(frame), verdict, now_ms, counts)
        if wanted and said is not None:
            assert found == [(said.frame, Verdict.TAKEN)], f"not obeyed at {now_ms} ms: {said}"
    _let_pass(robot, oracle, trace, now_ms, now_ms + 2 * TTL_MS)
    return counts


def _judge(
    oracle: Oracle, said: Said | None, verdict: Verdict, now_ms: int, counts: Counter[str]
) -> None:
    if said is None:
        # One in 65,536 damages is hidden by another session's start: the other rules catch it.
        assert verdict is not Verdict.TAKEN, "it obeyed what nobody has said"
        return
    if not isinstance(said.frame.body, MOTION):
        assert verdict is Verdict.TAKEN, f"refused {said}"
    else:
        counts["taken" if verdict is Verdict.TAKEN else "refused"] += 1
    if verdict is Verdict.TAKEN:
        assert oracle.may(said, now_ms), f"wrong execution at {now_ms} ms: {said}"
        oracle.took(said, now_ms)


def _let_pass(robot: Core, oracle: Oracle, trace: Trace, now_ms: int, until_ms: int) -> int:
    """Check the wheels on the way: they do what the oracle allows, and nothing else."""
    while now_ms < until_ms:
        now_ms = min(until_ms, now_ms + 7) if until_ms - now_ms < 2000 else now_ms + 199
        robot.tick(trace.clock_ms + now_ms)
        assert robot.wheels_mmps == oracle.wheels(now_ms), f"wheels at {now_ms} ms"
    return now_ms
