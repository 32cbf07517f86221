"""The control loop: the one place that moves the robot, and stops it at every change of operator.

It gives the robot a set-point at a steady beat, because the robot's own watchdog waits for it,
and at once when a new command changes what the robot shall do. All calls belong to the event
loop. The callbacks come after the robot was told, and must not call back into the loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections import Counter
from typing import TYPE_CHECKING, Final

from wax.control import gate
from wax.control.gate import GateState, Hold, Setpoint, TurnView
from wax.control.helm import Helm
from wax.control.turns import PlaceLost, TurnEnded, TurnRenewed, TurnStarted

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.config import DriveSettings
    from wax.control.gate import Command, Refusal
    from wax.control.turns import TurnEvent, Turns
    from wax.robot.driver import Driver, Limits, RobotState

MIN_GAP_S: Final = 0.005
"""Two set-points are never closer together, so that a slow serial line is not flooded."""

MAX_LATE_S: Final = 0.2
MIN_LATE_S: Final = 0.1
"""A beat that is late by more than this stops the robot, and neutral must come first.

It is the time after which the robot's own watchdog stops it, so that a robot that has stopped by
itself does not start by itself; at most `MAX_LATE_S`. Less than `MIN_LATE_S` would stop a robot
for every hiccup of a busy computer; commands that are too old by then are refused all the same.
"""


class ControlLoop:
    """Holds turns, gate and robot together.

    `link_delay_s` is asked for the operator's one-way delay until it is known, and again when
    the turn renews or the operator connects anew. `on_events` gets what happened to the turns;
    `on_status` gets the operator, whether the robot moves for him, and a sentence if it may not,
    whenever one of them changes.
    """

    def __init__(
        self,
        *,
        clock: Clock,
        turns: Turns,
        driver: Driver,
        settings: DriveSettings,
        link_delay_s: Callable[[int], float | None],
        on_events: Callable[[tuple[TurnEvent, ...]], None],
        on_status: Callable[[int, bool, str | None], None],
    ) -> None:
        self._clock = clock
        self._turns = turns
        self._helm = Helm(driver)
        self._settings = settings
        self._link_delay_s = link_delay_s
        self._on_events = on_events
        self._on_status = on_status
        self._period_s = 1 / settings.loop_hz
        self._max_late_s = _max_late_s(self._helm.limits)

        self._gate = GateState()
        self._one_way_s: float | None = None
        self._status: tuple[int, bool, str | None] | None = None
        self._counts: Counter[str] = Counter()
        self._latest_ms = 0.0

        self._stopped = False
        self._due_s = math.inf  # until the first step
        self._steered_s = -math.inf
        self._hurry = asyncio.Event()

    # --- the beat --------------------------------------------------------------------------

    async def run(self) -> None:
        """Keep the beat until cancelled, idle after `stop`; however it ends, the robot stands."""
        try:
            while not self._stopped:
                now_s = self._clock.now_s()
                if now_s - self._steered_s >= MIN_GAP_S:
                    self.step(now_s)
                await self._rest()
            await asyncio.Event().wait()
        finally:
            self.stop()

    def stop(self) -> None:
        """Stop the robot now, and move it never again; safe to call twice."""
        self._stopped = True
        self._helm.stop(self._turns.number)

    def step(self, now_s: float) -> None:
        """Do what is due and give the robot its set-point."""
        if self._stopped:
            return
        self._hurry.clear()
        if self._is_late(now_s):
            self._counts["control.late"] += 1
            self._hold(now_s, Hold.LATE)
        self._follow(self._turns.tick(now_s), now_s)
        problem = self._watch(now_s)
        turn = self._turn()
        setpoint = Setpoint(reason=problem) if problem else self._decide(turn, now_s)
        failure = self._helm.steer(setpoint, turn.number)
        self._steered_s = self._clock.now_s()  # not now_s: a busy machine may pause in between
        if failure is not None:
            self._gate = gate.require_neutral(self._gate, now_s, Hold.FAULT)
        self._tell(turn, failure or setpoint.reason)

    def _is_late(self, now_s: float) -> bool:
        """Measure the beat against its schedule, which never drifts, and set the next one."""
        due_s = now_s if math.isinf(self._due_s) else self._due_s
        late_s = now_s - due_s
        if late_s >= 0:
            self._due_s = due_s + self._period_s * (math.floor(late_s / self._period_s) + 1)
            self._latest_ms = max(self._latest_ms, late_s * 1000)
        return late_s > self._max_late_s

    async def _rest(self) -> None:
        """Sleep until the next beat, or until a command is in a hurry; keep the gap either way."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(max(0.0, self._due_s - self._clock.now_s())):
                await self._hurry.wait()
        await asyncio.sleep(max(0.0, self._steered_s + MIN_GAP_S - self._clock.now_s()))

    # --- viewers ---------------------------------------------------------------------------

    def connect(self, viewer: int) -> None:
        """Take note of a viewer's page, there for the first time or with a fresh connection."""
        now_s = self._clock.now_s()
        self._follow(self._turns.connect(viewer, now_s), now_s)
        self._begin_anew(viewer, now_s)

    def returned(self, viewer: int) -> None:
        """Take note that a lost viewer is heard again; an operator begins with neutral."""
        now_s = self._clock.now_s()
        self._follow(self._turns.returned(viewer, now_s), now_s)
        self._begin_anew(viewer, now_s)

    def join(self, viewer: int) -> None:
        """Put a viewer into the queue."""
        now_s = self._clock.now_s()
        self._follow(self._turns.join(viewer, now_s), now_s)

    def leave(self, viewer: int) -> None:
        """Take a viewer out of the queue, or end his turn."""
        now_s = self._clock.now_s()
        self._follow(self._turns.leave(viewer, now_s), now_s)

    def lost(self, viewer: int) -> None:
        """Stop the robot at once if this is its operator, whose turn is kept for a while."""
        now_s = self._clock.now_s()
        if viewer == self._turns.operator and not self._turns.is_lost(viewer):
            self._hold(now_s, Hold.LOST)
        self._follow(self._turns.lost(viewer, now_s), now_s)

    def gone(self, viewer: int) -> None:
        """Forget a viewer."""
        now_s = self._clock.now_s()
        self._follow(self._turns.gone(viewer, now_s), now_s)

    def offer(self, viewer: int, command: Command) -> Refusal | None:
        """Take a command that has just arrived; a change of the set-point goes out at once."""
        now_s = self._clock.now_s()
        turn = self._turn()
        self._gate, refusal = gate.accept(
            self._gate, viewer, command, turn=turn, now_s=now_s, settings=self._settings
        )
        name = "accepted" if refusal is None else f"refused.{refusal.name.lower()}"
        self._counts[f"commands.{name}"] += 1
        if refusal is None and self._helm.would_change(self._decide(turn, now_s)):
            if now_s - self._steered_s >= MIN_GAP_S:
                self.step(now_s)
            else:
                self._hurry.set()
        return refusal

    def operator_stop(self, viewer: int) -> bool:
        """Stop the robot at once if `viewer` is this turn's operator; False if he is not."""
        if viewer != self._turns.operator:
            return False
        self._hold(self._clock.now_s(), Hold.STOPPED)
        return True

    @property
    def robot_state(self) -> RobotState:
        """How the robot was at the newest beat; that it does not answer is its problem then."""
        return self._helm.state

    def counts(self) -> dict[str, int]:
        """Return what was counted since the start, and how late the latest beat was."""
        return dict(sorted(self._counts.items())) | {
            "control.driver_failures": self._helm.failures,
            "control.latest_ms": round(self._latest_ms),
        }

    # --- turns, gate and robot -------------------------------------------------------------

    def _follow(self, events: tuple[TurnEvent, ...], now_s: float) -> None:
        """Stop the robot at every change of operator, before anybody hears of it."""
        for event in events:
            match event:
                case TurnStarted():
                    self._begin(event.number, now_s)
                case TurnEnded():
                    self._helm.stop(event.number)
                case TurnRenewed():
                    self._one_way_s = self._link_delay_s(event.operator) or self._one_way_s
                case PlaceLost():
                    pass
        if events:
            self._on_events(events)

    def _begin_anew(self, viewer: int, now_s: float) -> None:
        """Let a fresh page of the operator's count its commands from the start."""
        if viewer == self._turns.operator:
            self._begin(self._turns.number, now_s)

    def _begin(self, number: int, now_s: float) -> None:
        self._helm.stop(number)
        self._gate = gate.begin(number, now_s)
        self._one_way_s = None
        self._status = None

    def _hold(self, now_s: float, why: Hold) -> None:
        self._helm.stop(self._turns.number)
        self._gate = gate.require_neutral(self._gate, now_s, why)

    def _watch(self, now_s: float) -> str | None:
        """Say why the robot cannot be driven; after that, or a reconnection, neutral is first."""
        epoch = self._helm.epoch
        problem = self._helm.check(self._turns.number)
        if problem is not None or self._helm.epoch != epoch:
            self._gate = gate.require_neutral(self._gate, now_s, Hold.FAULT)
        return problem

    def _turn(self) -> TurnView:
        operator = self._turns.operator
        if operator is not None and self._one_way_s is None:
            self._one_way_s = self._link_delay_s(operator)
        return TurnView(
            number=self._turns.number,
            operator=operator,
            present=operator is not None and not self._turns.is_lost(operator),
            one_way_s=self._one_way_s,
        )

    def _decide(self, turn: TurnView, now_s: float) -> Setpoint:
        return gate.decide(self._gate, turn, now_s, self._settings, self._helm.limits)

    def _tell(self, turn: TurnView, reason: str | None) -> None:
        if turn.operator is None:
            return
        status = (turn.operator, self._helm.is_moving, reason)
        if status != self._status:
            self._status = status
            self._on_status(*status)


def _max_late_s(limits: Limits) -> float:
    return MAX_LATE_S if limits.ttl_s is None else min(MAX_LATE_S, max(MIN_LATE_S, limits.ttl_s))
