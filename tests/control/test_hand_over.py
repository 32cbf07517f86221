"""Turns, gate, stop and loop together, with events in any order and at the same instant.

A crowd of viewers joins, drives, loses the connection and returns, leaves, presses Stop and
releases it, while commands of this and of older turns arrive late or at the very moment at which a
turn ends. A driver logs its calls. Each command asks for a unique speed, so that the log shows
whose each motion is, and of which turn.

``WAX_STEPS=100000`` runs the full length in a minute or two.
"""

from __future__ import annotations

import os
import random
from collections import Counter
from dataclasses import dataclass, replace
from typing import Final

import pytest
from tests.control.rig import FakeOperators, make_loop
from tests.examples import share_of
from tests.idle_robot import IdleRobot
from tests.turned_clock import TurnedClock

from wax.config.drive import DriveSettings
from wax.config.turns import TurnSettings
from wax.control.command import Command
from wax.control.listener import Listener
from wax.control.turn_time import MAX_PAUSE_S
from wax.control.turns import TurnEnded, TurnEvent, TurnRenewed, Turns, TurnStarted
from wax.driver.interface import Limits, RobotState, Twist
from wax.sentence import says

TURN_S: Final = 3.0
GRACE_S: Final = 0.5
CROWD: Final = 6
ONE_WAY_S: Final = 0.05
TTL_S: Final = 0.15 + ONE_WAY_S
LIMITS: Final = Limits(linear_mps=0.4, angular_rps=1.0, ttl_s=0.2)


@dataclass(frozen=True)
class StateReport:
    """One line of the driver's log."""

    what: str
    turn: int
    at_s: float
    linear_mps: float = 0.0


class Log(IdleRobot):
    """A driver that logs its calls and their times."""

    kind = "log"
    limits = LIMITS

    def __init__(self, clock: TurnedClock) -> None:
        self._clock = clock
        self.told: list[StateReport] = []
        self.now = RobotState(connected=True, epoch=1)

    def apply(self, twist: Twist, turn: int) -> None:
        self.told.append(StateReport("apply", turn, self._clock.time_s, twist.linear_mps))

    def set_axis(self, name: str, position: float, turn: int) -> None:
        raise AssertionError("this robot has no axes")

    def stop(self, turn: int) -> None:
        self.told.append(StateReport("stop", turn, self._clock.time_s))

    def state(self) -> RobotState:
        return self.now


class Near(FakeOperators):
    """People who are all equally far away."""

    def link_delay_s(self, number: int) -> float | None:
        return ONE_WAY_S


@dataclass(frozen=True)
class Sent:
    """A command in flight."""

    viewer: int
    command: Command


class Crowd(Listener):
    """Simulates people and networks at random, and checks the log after each step."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.clock = TurnedClock()
        self.driver = Log(self.clock)
        self.turns = Turns(TurnSettings(turn_s=TURN_S, grace_s=GRACE_S))
        self.loop = make_loop(
            self.clock,
            self.driver,
            self,
            turns=self.turns,
            operators=Near(),
            drive=DriveSettings(max_stop_distance_m=10.0),
        )
        self.here: list[int] = []
        self.newest_viewer = 0
        self.seq = 0
        self.under_way: list[Sent] = []
        self.asked: dict[float, Sent] = {}
        self.operator: int | None = None
        self.turn = 0
        self.lost: set[int] = set()
        self.stops = 0
        self.is_stopped = False
        self.neutral_since_s: float | None = None  # when the neutral command that counts was sent
        self.hold_s = 0.0
        self.checked = 0
        self.last_apply_turn = 0
        self.stop_since_apply = False
        self.happened: Counter[str] = Counter()

    # --- what happens ----------------------------------------------------------------------

    def step(self) -> None:
        """Let time pass or something happen, and check the driver's log."""
        act = self.rng.choices(ACTS, WEIGHTS)[0]
        self.happened[act] += 1
        getattr(self, f"do_{act}")()
        self._check()

    def do_beat(self) -> None:
        self.clock.time_s += self.rng.choice([0.005, 0.02, 0.02, 0.02])
        self.loop.step(self.clock.time_s)

    def do_late_beat(self) -> None:
        late_s = self.rng.choice([0.1, 0.19, 0.3, 5.0])
        self.clock.time_s += late_s
        if late_s > 0.25:
            self._hold()
        self.loop.step(self.clock.time_s)

    def do_expiry(self) -> None:
        """Set the clock to the end of the turn; the event that then comes first varies."""
        ends_s = self.turns.ends_s
        if ends_s is not None and 0 <= ends_s - self.clock.time_s < TURN_S + MAX_PAUSE_S:
            self._drive_until(ends_s)
            self.clock.time_s = max(self.clock.time_s, ends_s)

    def do_connect(self) -> None:
        if len(self.here) < CROWD:
            self.newest_viewer += 1
            self.here.append(self.newest_viewer)
            self.loop.connect(self.newest_viewer)

    def do_reload(self) -> None:
        viewer = self._somebody()
        if viewer is not None and not self.turns.is_lost(viewer):
            if viewer == self.operator:
                self._hold()
            self.loop.connect(viewer)

    def do_join(self) -> None:
        viewer = self._somebody()
        if viewer is not None:
            self.loop.join(viewer)

    def do_leave(self) -> None:
        viewer = self._somebody()
        if viewer is not None:
            self.loop.leave(viewer)

    def do_lose(self) -> None:
        viewer = self._somebody()
        if viewer is not None:
            self.lost.add(viewer)
            if viewer == self.operator:
                self._hold()
            self.loop.lost(viewer)

    def do_return(self) -> None:
        if self.lost:
            viewer = self.rng.choice(sorted(self.lost))
            self.lost.discard(viewer)
            if viewer == self.operator:
                self._hold()
            self.loop.returned(viewer)

    def do_gone(self) -> None:
        viewer = self._somebody()
        if viewer is not None:
            self.here.remove(viewer)
            self.lost.discard(viewer)
            self.loop.gone(viewer)

    def do_stop(self) -> None:
        before = len(self.driver.told)
        number = self.loop.press_stop(says("somebody"), viewer=self._somebody())
        assert self.driver.told[before].what == "stop"
        self.stops += not self.is_stopped  # another press keeps the number
        assert number == self.stops
        self.is_stopped = True

    def do_release(self) -> None:
        viewer = self.operator if self.rng.random() < 0.7 else self._somebody()
        if viewer is None or not self.is_stopped:
            return
        number = self.stops - (self.rng.random() < 0.2)
        rightful = viewer == self.operator and viewer not in self.lost and number == self.stops
        refusal = self.loop.release_stop(viewer, number, self.clock.time_s)
        assert (refusal is None) is rightful
        if rightful:
            self.is_stopped = False
            self._hold()

    def do_reconnect(self) -> None:
        """Let the robot reconnect, or have a problem for a while."""
        state = self.driver.now
        problem = "The battery is empty." if self.rng.random() < 0.3 else None
        self.driver.now = replace(state, epoch=state.epoch + 1, problem=problem)
        self._hold()

    def do_send(self) -> None:
        """Send a command by any viewer, of the current turn or an earlier one."""
        viewer = self.operator if self.rng.random() < 0.8 else self._somebody()
        if viewer is not None:
            turn = self.turn if self.rng.random() < 0.85 else max(0, self.turn - 1)
            self._send(viewer, turn)

    def do_arrive(self) -> None:
        """Let some of the commands in flight arrive, in any order."""
        self.rng.shuffle(self.under_way)
        for _ in range(self.rng.randint(0, len(self.under_way))):
            sent = self.under_way.pop()
            self._offer(sent)
            if self.rng.random() < 0.1:
                self._offer(sent)

    def do_drive(self) -> None:
        """Let the operator drive as people do, for a moment."""
        self._drive_until(self.clock.time_s + 0.2)

    # --- how it happens --------------------------------------------------------------------

    def _drive_until(self, until_s: float) -> None:
        while self.operator is not None and self.clock.time_s + 0.02 < until_s:
            if self.rng.random() < 0.02:
                return
            self._send(self.operator, self.turn)
            self._offer(self.under_way.pop())
            self.do_beat()
            self._check()

    def _send(self, viewer: int, turn: int) -> None:
        self.seq += 1
        neutral = self.rng.random() < (0.5 if self.neutral_since_s is None else 0.1)
        share = 0.0 if neutral else 0.1 + 0.9 * self.rng.random()
        command = Command(
            seq=self.seq,
            turn=turn,
            sent_s=self.clock.time_s,
            linear=share,
            angular=0.0,
            held=share != 0,
            speed="fast",
            seen_s=self.clock.time_s,
            heard_s=self.clock.time_s,
        )
        sent = Sent(viewer, command)
        self.under_way.append(sent)
        self.asked[share * LIMITS.linear_mps] = sent

    def _offer(self, sent: Sent) -> None:
        # The turn may end with this arrival; neutral counts for the turn that it was sent in.
        command, before_s = sent.command, self.hold_s
        self.loop.handle_command(sent.viewer, command)
        is_his = sent.viewer == self.operator and command.turn == self.turn
        if is_his and command.linear == 0 and self.hold_s == before_s <= command.sent_s:
            self.neutral_since_s = command.sent_s

    def _somebody(self) -> int | None:
        return self.rng.choice(self.here) if self.here else None

    def _hold(self) -> None:
        self.hold_s, self.neutral_since_s = self.clock.time_s, None

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        """Track the turns by their events, and check that the robot was stopped before."""
        for event in events:
            match event:
                case TurnStarted():
                    self._check_stopped(event.number)
                    assert event.number > self.turn
                    self.turn, self.operator = event.number, event.operator
                    self._hold()
                    self.happened["turns"] += 1
                case TurnEnded():
                    self._check_stopped(event.number)
                    self.operator = None
                case TurnRenewed():
                    assert event.number == self.turn

    # --- what must be so -------------------------------------------------------------------

    def _check(self) -> None:
        for told in self.driver.told[self.checked :]:
            if told.what == "stop":
                self.stop_since_apply = True
                continue
            assert told.turn >= self.last_apply_turn, "a set-point of an old turn"
            assert told.turn == self.last_apply_turn or self.stop_since_apply, "no stop between"
            self.last_apply_turn, self.stop_since_apply = told.turn, False
            if told.linear_mps != 0:
                self._check_motion(told)
        self.checked = len(self.driver.told)

    def _check_stopped(self, turn: int) -> None:
        assert StateReport("stop", turn, self.clock.time_s) in self.driver.told[self.checked :]

    def _check_motion(self, told: StateReport) -> None:
        sent = self.asked[told.linear_mps]
        assert sent.command.turn == told.turn == self.turn, "a motion of an old turn"
        assert sent.viewer == self.operator, "a motion of somebody else's"
        assert sent.viewer not in self.lost, "a motion of a lost operator"
        assert not self.is_stopped, "a motion while a stop is latched"
        assert self.driver.now.problem is None, "a motion of a robot that is not ready"
        assert self.neutral_since_s is not None, "a motion before neutral"
        assert sent.command.sent_s >= self.hold_s, "a motion from before the stop"
        assert told.at_s - sent.command.sent_s <= TTL_S + 1e-9, "a motion that is too old"
        self.happened["motions"] += 1


ACTS: Final = (
    "beat",
    "late_beat",
    "expiry",
    "connect",
    "reload",
    "join",
    "leave",
    "lose",
    "return",
    "gone",
    "stop",
    "release",
    "reconnect",
    "send",
    "arrive",
    "drive",
)
WEIGHTS: Final = (30, 1, 4, 3, 1, 6, 1, 3, 6, 1, 2, 6, 2, 20, 20, 8)


def run(steps: int, seed: int) -> Counter[str]:
    """Run this many steps, checking each; return how often each event happened."""
    crowd = Crowd(seed)
    for _ in range(steps):
        crowd.step()
    return crowd.happened


@pytest.mark.timeout(3600)
def test_no_motion_of_an_old_turn() -> None:
    """After a change of turn there is no motion of an old turn, and always a stop in between."""
    steps = int(os.environ.get("WAX_STEPS", share_of(5000)))
    happened = run(steps, seed=5)
    assert happened["motions"] >= steps // 5
    assert happened["turns"] >= steps // 50
    assert all(happened[act] for act in ACTS)
