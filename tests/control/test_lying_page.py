"""A page that lies about its clock against the gate, and an honest one, which must not be refused.

The tests record when each command was really sent. The links are `tests.link`'s.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from typing import TYPE_CHECKING, Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.rules import RULES, VOUCHED
from tests.examples import at_length, examples
from tests.link.model import Direction
from tests.link.profile import Profile, load

from wax.control import gate
from wax.control.beats import Beats
from wax.control.command import Command
from wax.control.turn_view import TurnView

if TYPE_CHECKING:
    from tests.link.profile import DirectionSettings

    from wax.control.gate import GateState

ADA, TURN = 1, 5
MOST_ONE_WAY_S: Final = RULES.max_command_age_s - RULES.max_age_s


@dataclass(frozen=True)
class Told:
    """A command on its way: when it was sent, what the page claims, and the beat that it names."""

    sent_s: float
    claimed_s: float
    beat: str | None


def turn(one_way_s: float | None) -> TurnView:
    return TurnView(TURN, ADA, present=True, one_way_s=one_way_s, sees=False, picture=VOUCHED)


class Server:
    """Beats and gate, connected as in the server."""

    def __init__(self, one_way_s: float | None) -> None:
        self.beats = Beats()
        self.turn = turn(one_way_s)
        self.gate: GateState = gate.begin(TURN, 0.0)
        self.refused = 0
        self._seqs = count(1)

    def hear(self, told: Told, now_s: float, *, linear: float = 1.0) -> None:
        heard_s = self.beats.sent_s(told.beat)
        held = linear != 0
        command = Command(
            next(self._seqs), TURN, told.claimed_s, linear, 0.0, held, "fast", heard_s=heard_s
        )
        self.gate, refusal = gate.accept(
            self.gate, ADA, command, turn=self.turn, now_s=now_s, rules=RULES
        )
        self.refused += refusal is not None

    def moves(self, now_s: float) -> bool:
        self.gate, setpoint = gate.decide(self.gate, self.turn, None, now_s, RULES)
        return not setpoint.twist.is_zero


claims = st.one_of(
    st.just(math.inf),  # the time of arrival, to a tenth of a millisecond
    st.floats(-0.5, 10.0),
)
"""How much later than the truth a command claims to be sent."""


@examples(300)
@given(
    one_way_s=st.none() | st.floats(0.0, MOST_ONE_WAY_S),
    lies=st.lists(st.tuples(claims, st.floats(0.0, 6.0)), min_size=1, max_size=40),
    guesses=st.sampled_from(["the newest", "the first", "its own", "none"]),
)
def test_a_page_that_lies_moves_nothing_for_long(
    one_way_s: float | None, lies: list[tuple[float, float]], guesses: str
) -> None:
    """Soon after a page falls silent the robot stands, whatever it claims and the uplink delays.

    The page is silent from 1.0 s on, its commands are delayed at random, and it claims a random
    delay of its link.
    """
    server = Server(one_way_s)
    newest = first = server.beats.send(0.0)
    arrivals: list[tuple[float, int, Told]] = []
    last_s = 0.0
    for number, (late_s, delay_s) in enumerate(lies):
        last_s = number * 1.0 / len(lies)
        newest = server.beats.send(last_s)  # a downlink without any delay
        came_s = last_s + delay_s
        named = {"the newest": newest, "the first": first, "its own": "guess_", "none": None}
        claimed_s = came_s if math.isinf(late_s) else last_s + late_s
        heappush(arrivals, (came_s, number, Told(last_s, claimed_s, named[guesses])))
    server.hear(Told(0.0, 0.0, first), 0.0, linear=0.0)
    bound_s = RULES.max_age_s + 2 * (one_way_s or 0.0) + 0.35
    now_s = 0.0
    while now_s < last_s + 7.0:
        while arrivals and arrivals[0][0] <= now_s:
            came_s, _, told = heappop(arrivals)
            server.hear(told, came_s)
        if server.moves(now_s):
            assert now_s <= last_s + bound_s + 1e-6
            assert guesses in ("the newest", "the first")
        now_s += RULES.period_s


@pytest.mark.parametrize("late_s", [1.5, 5.0])
def test_an_uplink_that_is_late_is_so_for_a_liar_too(late_s: float) -> None:
    """A page that dates its commands by their arrival gains nothing on a delayed uplink."""
    server = Server(0.001)
    beat = server.beats.send(0.0)
    server.hear(Told(0.0, 0.0, beat), 0.0, linear=0.0)
    for number in range(321):
        sent_s = 0.02 * number
        beat = server.beats.send(sent_s)
        server.hear(Told(sent_s, sent_s + late_s, beat), sent_s + late_s)
        assert not server.moves(sent_s + late_s)
    assert server.refused == 321


def _profile(delay_ms: float, jitter_ms: float, loss: float, *, reorder: bool = False) -> Profile:
    way = {
        "queue_bytes": 1_000_000,
        "delay_ms": delay_ms,
        "jitter": {"distribution": "uniform", "ms": jitter_ms},
        "loss": {"in_good": loss},
        "reorder": reorder,
    }
    return Profile.model_validate({"about": "for this test", "down": way, "up": way})


LINKS: Final = {
    "60 ± 30 ms, 2 % lost": (_profile(60.0, 30.0, 0.02, reorder=True), 50, False),
    "200 ms": (_profile(200.0, 5.0, 0.0), 50, False),
    "340 ms, nearly too long": (_profile(340.0, 5.0, 0.0), 50, False),
    "a modem": (load("modem-56k"), 20, True),
}
_DATAGRAM: Final = 120  # a beat's, with its headers
_SET_POINT: Final = 200
_PICTURE: Final = 1000


@pytest.mark.parametrize("seed", [1, *at_length(2)])
@pytest.mark.parametrize(("profile", "hz", "is_thin"), LINKS.values(), ids=LINKS.keys())
def test_an_honest_page_is_never_refused(
    profile: Profile, hz: int, is_thin: bool, seed: int
) -> None:
    """Over a drivable link, even with lost and late beats, every command counts."""
    drive = Drive(profile, hz=hz, is_thin=is_thin, seed=seed)
    drive.run(60.0)
    assert drive.server.refused == 0
    assert drive.moved >= 0.99 * drive.ticks > 2500


class Drive:
    """An honest page that presses at 1.0 s and drives on, over a line with pictures.

    In `moved` of the `ticks` after 2.0 s the robot moved.
    """

    def __init__(self, profile: Profile, *, hz: int, is_thin: bool, seed: int) -> None:
        self.up = Direction(profile.up, seed=seed, way="up", start_s=0.0)
        self.down = Direction(profile.down, seed=seed, way="down", start_s=0.0)
        self.server = Server(sum(_least_s(way) for way in (profile.up, profile.down)) / 2)
        self.ticks = self.moved = 0
        self._hz, self._is_thin = hz, is_thin
        self._rng = random.Random(seed)
        self._beat = ""
        self._sent: dict[bytes, Told] = {}

    def run(self, for_s: float) -> None:
        due = dict.fromkeys((self._command, self._picture, self._pong, self._tick), 0.0)
        now_s = 0.0
        while now_s < for_s:
            now_s = min(*due.values(), self.up.next_s(), self.down.next_s())
            self._carry(now_s)
            for act in [act for act, at_s in due.items() if at_s <= now_s]:
                due[act] += act(now_s)

    def _carry(self, now_s: float) -> None:
        for _, packet in self.down.due(now_s):
            self._beat = packet.decode().strip() or self._beat
        for came_s, packet in self.up.due(now_s):
            told = self._sent.pop(packet)
            is_neutral = told.sent_s < 1.0
            self.server.hear(told, came_s, linear=0.0 if is_neutral else 1.0)
            if is_neutral:
                self.server.refused = 0
            if self.server.beats.is_due(came_s, is_thin=self._is_thin):
                self._say_beat(came_s)

    def _say_beat(self, now_s: float) -> None:
        self.down.arrive(self.server.beats.send(now_s).encode().ljust(_DATAGRAM), now_s)

    def _command(self, now_s: float) -> float:
        if self._beat:
            packet = f"{now_s}".encode().ljust(_SET_POINT)
            self._sent[packet] = Told(now_s, now_s, self._beat)
            self.up.arrive(packet, now_s)
        return self._rng.uniform(0.9, 1.1) / self._hz

    def _picture(self, now_s: float) -> float:
        self.down.arrive(b" " * _PICTURE, now_s)
        return self._rng.uniform(0.9, 1.1) * (0.4 if self._is_thin else 0.033)

    def _pong(self, now_s: float) -> float:
        self._say_beat(now_s)
        return 1.0 if self._is_thin else 0.2

    def _tick(self, now_s: float) -> float:
        moves = self.server.moves(now_s)
        if now_s > 2.0:  # it has started driving by then
            self.ticks += 1
            self.moved += moves
        return RULES.period_s


def _least_s(way: DirectionSettings) -> float:
    """Return the shortest delay that a ping or pong can measure."""
    earliest_ms = 0.0 if way.jitter is None else way.jitter.earliest_ms
    on_the_line_s = 0.0 if way.rate_bps is None else 8 * _DATAGRAM / way.rate_bps
    return (way.delay_ms - earliest_ms) / 1000 + on_the_line_s
