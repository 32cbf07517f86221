"""The control loop: the one place that moves the robot, and stops it at every change of operator.

It sends the robot a set-point at a fixed rate, which the robot's own watchdog expects, and at once
when a new command changes the set-point. Call everything from the event loop.
"""

from __future__ import annotations

import asyncio
import math
from collections import Counter
from typing import TYPE_CHECKING, Final

from wax.control import gate, gauge_limits, ramp, speed, stop_latch
from wax.control.controls_loop import ControlsLoop, is_driving
from wax.control.gate import GateState, Setpoint
from wax.control.gauge_limits import GaugeHold
from wax.control.loop_timer import LoopTimer
from wax.control.operator_delay import OperatorDelay
from wax.control.reasons import Hold, Limit
from wax.control.rules import Rules
from wax.control.safe_driver import SafeDriver
from wax.control.stop_latch import StopLatch
from wax.control.turn_view import TurnView
from wax.control.turns import TurnEnded, TurnRenewed, TurnStarted

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.clock import Clock
    from wax.config.settings import Settings
    from wax.control.command import Command
    from wax.control.controls import Operation
    from wax.control.driving_view import DrivingView
    from wax.control.fairness import Person
    from wax.control.listener import Listener
    from wax.control.loop_timer import Lateness
    from wax.control.operators import Operators
    from wax.control.reasons import Refusal
    from wax.control.stop_latch import LatchedStop, Releaser
    from wax.control.turns import TurnEvent, Turns
    from wax.driver.interface import Driver, RobotState
    from wax.sentence import Sentence

MIN_GAP_S: Final = 0.005
"""Set-points are never closer together than this, so that a slow serial line is not flooded."""

_AFTER_S: Final = 0.001
"""A command is checked this long after it expires: timers may fire a little early."""


class ControlLoop:
    """Connects turns, gate and robot."""

    def __init__(
        self,
        *,
        clock: Clock,
        settings: Settings,
        driver: Driver,
        turns: Turns,
        operators: Operators,
        view: DrivingView,
    ) -> None:
        self._clock = clock
        self._turns = turns
        self._safe_driver = SafeDriver(driver)
        self._rules = Rules.of(settings.drive, settings.robot, driver.limits)
        self._operator_delay = OperatorDelay(operators.link_delay_s, self._rules)
        self._operators = operators
        self._view = view
        self._listeners: tuple[Listener, ...] = ()
        self._timer = LoopTimer(loop_hz=settings.drive.loop_hz, ttl_s=driver.limits.ttl_s)
        self._latch = StopLatch()
        self._gate = GateState()
        self._controls = ControlsLoop(settings.controls, self._rules, self._safe_driver)
        self._gauges = settings.gauges
        self._gauge_hold = GaugeHold()
        self._target = Setpoint()  # where the ramp ends
        self._status: tuple[int, bool, Sentence | None, float] | None = None
        self._counts: Counter[str] = Counter()
        self._first_axes: Mapping[str, float] = {}
        self._stopped = False
        self._steered_s = -math.inf
        self._is_urgent = False
        self._woken: asyncio.Future[None] | None = None
        self._alarm: asyncio.TimerHandle | None = None

    def listen(self, *listeners: Listener) -> None:
        """Tell these, in order, of everything from now on."""
        self._listeners += listeners

    # --- the beat --------------------------------------------------------------------------

    async def run(self) -> None:
        """Run until cancelled, idle after `stop`; however it ends, the robot is stopped."""
        try:
            while not self._stopped:
                now_s = self._clock.now_s()
                if self._gap_s(now_s) == 0.0:
                    self.step(now_s)
                await self._sleep()
            await asyncio.Event().wait()
        finally:
            self.stop()

    def stop(self) -> None:
        """Stop the robot now and for good; safe to call twice."""
        self._stopped = True
        self._safe_driver.stop_even_if_lent(self._turns.number)
        self._safe_driver.operate({}, self._turns.number)

    def step(self, now_s: float) -> None:
        """Run one tick: do what is due and give the robot its set-point."""
        if self._stopped:
            return
        self._is_urgent = False
        if self._timer.is_too_late(now_s):
            self._counts["control.late"] += 1
            self._hold(now_s, Hold.LATE)
        self.tick_turns()
        problem = self._check_robot(now_s)
        turn = self._turn()
        self._target = Setpoint(reason=problem) if problem else self._decide(turn, now_s)
        after_s = now_s - self._steered_s
        setpoint = ramp.step(self._target, self._safe_driver.twist, after_s, self._rules)
        self._safe_driver.tell_passenger(is_operated=self._is_operated(turn))
        self._safe_driver.set_deadline(self._target.valid_until_s)
        failure = self._safe_driver.steer(setpoint, turn.number)
        self._steered_s = self._clock.now_s()  # not now_s: a busy machine may pause in between
        if self._gate.command is None:
            self._controls.release_moving()  # these, too, must be released and pressed again
        failure = failure or self._controls.send_changes(
            turn, may_move=self._target.holds, now_s=now_s
        )
        if failure is not None:
            self._gate = gate.require_neutral(self._gate, now_s, Hold.FAULT)
        for listener in self._listeners:
            listener.steered(self._target, self._safe_driver.twist, turn.number, now_s)
        self._report_status(turn, failure or self._target.reason)

    def tick_turns(self) -> None:
        """Do what is due in the turns; call it before reporting them, also between two steps.

        A turn's clock pauses while something keeps its operator from driving.
        """
        if self._stopped:
            return
        now_s = self._clock.now_s()
        while events := self._turns.tick(now_s, is_kept=self._is_kept(now_s)):
            self._handle_events(events, now_s)  # then again, for a turn that has just begun

    async def _sleep(self) -> None:
        """Sleep until the next tick, an urgent command or a command's expiry; keep the minimum gap.

        It uses a timer and a future, since each extra pass of a busy event loop adds delay.
        """
        self._woken = asyncio.get_running_loop().create_future()
        self._wake_in(self._sleep_s(self._clock.now_s()))
        await self._woken

    def _sleep_s(self, now_s: float) -> float:
        """Return the time until the next tick or the command's expiry, at least the minimum gap."""
        gap_s = self._gap_s(now_s)
        ends_s = self._target.valid_until_s + _AFTER_S - now_s
        return gap_s if self._is_urgent else max(gap_s, min(self._timer.rest_s(now_s), ends_s))

    def _wake_in(self, rest_s: float) -> None:
        if self._woken is None:
            return
        if self._alarm is not None:
            self._alarm.cancel()
        self._alarm = asyncio.get_running_loop().call_later(rest_s, _wake, self._woken)

    def _gap_s(self, now_s: float) -> float:
        """Return how long the loop must wait before the next set-point."""
        return max(0.0, self._steered_s + MIN_GAP_S - now_s)

    # --- viewers ---------------------------------------------------------------------------

    def connect(self, viewer: int, person: Person | None = None, *, is_here: bool = True) -> None:
        """Register a viewer's page when it connects or reconnects, and the person behind it.

        With `is_here` false the viewer waits elsewhere, without a connection.
        """
        now_s = self._clock.now_s()
        self._handle_events(self._turns.connect(viewer, now_s, person, is_here=is_here), now_s)
        self._controls.reset_viewer(viewer)
        self._restart_gate(viewer, now_s)

    def returned(self, viewer: int) -> None:
        """Register that a lost viewer is back; an operator starts from neutral."""
        now_s = self._clock.now_s()
        self._handle_events(self._turns.returned(viewer, now_s), now_s)
        self._restart_gate(viewer, now_s)

    def update_person(self, viewer: int, person: Person) -> None:
        """Update the person behind a viewer."""
        now_s = self._clock.now_s()
        self._handle_events(self._turns.update_person(viewer, person, now_s), now_s)

    def join(self, viewer: int) -> Sentence | None:
        """Put a viewer into the queue, or return why not."""
        now_s = self._clock.now_s()
        self._handle_events(self._turns.join(viewer, now_s), now_s)
        return self._turns.refusal(viewer)

    def answer_call(self, viewer: int) -> None:
        """Register that a viewer is present, which answers any call to them."""
        now_s = self._clock.now_s()
        self._handle_events(self._turns.answer(viewer, now_s), now_s)

    def end_turn(self) -> None:
        """End the turn, as the host asks."""
        now_s = self._clock.now_s()
        self._handle_events(self._turns.end(now_s), now_s)

    def hold_queue(self, is_held: bool) -> None:
        """Pause or resume the queue, as the host asks."""
        now_s = self._clock.now_s()
        self._handle_events(self._turns.hold(is_held, now_s), now_s)

    def leave(self, viewer: int) -> None:
        """Take a viewer out of the queue, or end their turn."""
        now_s = self._clock.now_s()
        self._handle_events(self._turns.leave(viewer, now_s), now_s)

    def lost(self, viewer: int) -> None:
        """Stop the robot at once if this is its operator, whose turn is kept for the grace time."""
        now_s = self._clock.now_s()
        if viewer == self._turns.operator and not self._turns.is_lost(viewer):
            self._hold(now_s, Hold.LOST)
        self._handle_events(self._turns.lost(viewer, now_s), now_s)

    def gone(self, viewer: int) -> None:
        """Forget a viewer."""
        now_s = self._clock.now_s()
        self._controls.reset_viewer(viewer)
        self._handle_events(self._turns.gone(viewer, now_s), now_s)

    def handle_command(self, viewer: int, command: Command) -> Refusal | None:
        """Handle a command that has just arrived; a changed set-point is sent at once."""
        now_s = self._clock.now_s()
        turn = self._turn()
        self._gate, refusal = gate.accept(
            self._gate, viewer, command, turn=turn, now_s=now_s, rules=self._rules
        )
        name = "accepted" if refusal is None else f"refused.{refusal.name.lower()}"
        self._counts[f"commands.{name}"] += 1
        if refusal is None and command.held:
            self._turns.record_motion(viewer, now_s)
        if refusal is None and self._changes_setpoint(turn, now_s):
            self._send_soon(now_s)
        for listener in self._listeners:
            listener.command_handled(viewer, command, refusal, now_s)
        return refusal

    def operate(
        self, viewer: int, asked: Operation, *, is_host: bool, one_way_s: float | None
    ) -> Refusal | None:
        """Handle the controls that a viewer holds and sets; a change is sent at once.

        `one_way_s` is the present delay of their link; for the operator, the turn's delay counts.
        """
        now_s = self._clock.now_s()
        turn = self._turn()
        refusal = self._controls.accept(
            viewer,
            asked,
            turn=turn,
            is_host=is_host,
            one_way_s=one_way_s,
            is_stopped=self.latched is not None,
            now_s=now_s,
        )
        name = "accepted" if refusal is None else f"refused.{refusal.name.lower()}"
        self._counts[f"controls.{name}"] += 1
        if refusal is None and (asked.held or asked.wanted) and is_driving(viewer, turn):
            self._turns.record_motion(viewer, now_s)
        if refusal is None and self._controls.has_changes(
            turn, may_move=self._target.holds, now_s=now_s
        ):
            self._send_soon(now_s)
        return refusal

    def _send_soon(self, now_s: float) -> None:
        """Send the robot its set-point now, or as soon as the minimum gap allows."""
        gap_s = self._gap_s(now_s)
        if gap_s > 0.0:
            self._is_urgent = True
            self._wake_in(gap_s)
        else:
            self.step(now_s)
            self._wake_in(self._sleep_s(now_s))

    # --- stop, and what else keeps the robot standing ------------------------------------------

    def press_stop(
        self,
        by: Sentence,
        *,
        viewer: int | None = None,
        by_host: bool = False,
        release_after_s: float = 0.0,
    ) -> int:
        """Stop the robot now, before anything else, until the stop is released.

        Returns the number of the stop in force. `by` names who pressed it. An operator may release
        it after `release_after_s`, or at once if nobody else has pressed it.
        """
        try:
            self._safe_driver.stop_even_if_lent(self._turns.number)
        finally:
            self._latch = stop_latch.press(
                self._latch,
                by,
                self._clock.now_s(),
                viewer=viewer,
                by_host=by_host,
                release_after_s=release_after_s,
            )
        self._controls.release_held()
        self._counts["stops.pressed"] += 1
        return self._latch.newest

    def release_stop(self, by: Releaser, stop: int, sent_s: float | None) -> Refusal | None:
        """Release the stop with this number; the robot then waits for a neutral command.

        `sent_s` is None for an HTTP request, which has no timestamp.
        """
        now_s = self._clock.now_s()
        self._latch, refusal = stop_latch.release(
            self._latch, by, stop, sent_s, turn=self._turn(), now_s=now_s
        )
        name = "released" if refusal is None else f"refused.{refusal.name.lower()}"
        self._counts[f"stops.{name}"] += 1
        if refusal is None:
            self._hold(now_s, Hold.STOPPED)
        return refusal

    def would_add_nothing(self, viewer: int | None) -> bool:
        """Return whether a press by this viewer would leave the stop in force as it is."""
        return stop_latch.adds_nothing(self._latch, viewer, self._clock.now_s())

    @property
    def latched(self) -> LatchedStop | None:
        """The stop in force, None if there is none."""
        return self._latch.stop

    def lend_driver(self, reason: Sentence | None) -> None:
        """Lend the driver to another user for this reason, or take it back with None.

        Meanwhile the reason is reported as the robot's problem and the loop calls the driver only
        to stop it: when somebody presses Stop, or when the loop ends. Taking it back counts as a
        new connection: neutral must come first.
        """
        self._safe_driver.lend(reason, self._turns.number)

    @property
    def robot_state(self) -> RobotState:
        """Return the robot's state at the newest tick; its `problem` says if it does not answer."""
        return self._safe_driver.state

    @property
    def control_values(self) -> Mapping[str, float]:
        """The values of the controls that were set, not held."""
        return self._controls.values

    @property
    def operated(self) -> Mapping[str, float]:
        """The numbers of the controls that are held or were set, as the robot was sent them."""
        return self._safe_driver.operated

    @property
    def first_axes(self) -> Mapping[str, float]:
        """The positions, when the turn began, of the axes that had been moved."""
        return self._first_axes

    @property
    def is_taken(self) -> bool:
        """Whether the person aboard keeps every operator from driving."""
        aboard = self._safe_driver.state.aboard
        return aboard is not None and aboard.mode != "free"

    @property
    def stepped_s(self) -> float:
        """When the robot was last sent a set-point."""
        return self._steered_s

    @property
    def lateness(self) -> Lateness:
        """How late the ticks since the start were."""
        return self._timer.lateness

    def counts(self) -> dict[str, float]:
        """Return the counts since the start, and how late the ticks of the last minute were."""
        return dict(sorted(self._counts.items())) | {
            "control.driver_failures": self._safe_driver.failures,
            "control.jitter_p99_ms": round(self._timer.jitter_p99_ms, 1),
            "control.latest_ms": round(self._timer.latest_ms, 1),
        }

    # --- turns, gate and robot -------------------------------------------------------------

    def _handle_events(self, events: tuple[TurnEvent, ...], now_s: float) -> None:
        """Stop the robot at every change of operator, before anybody hears of it."""
        for event in events:
            match event:
                case TurnStarted():
                    self._begin(event.number, now_s)
                    self._first_axes = self._safe_driver.axes
                case TurnEnded():
                    self._controls.release_held(event.operator)
                    self._safe_driver.stop(event.number)
                case TurnRenewed():
                    self._operator_delay.renew(event.operator)
        for listener in self._listeners if events else ():
            listener.turn_events(events)

    def _restart_gate(self, viewer: int, now_s: float) -> None:
        """Restart the gate for a new page of the operator's, which numbers anew."""
        if viewer == self._turns.operator:
            self._begin(self._turns.number, now_s)

    def _begin(self, number: int, now_s: float) -> None:
        self._safe_driver.stop(number)
        self._gate = gate.begin(number, now_s)
        self._controls.release_moving()
        self._operator_delay.begin()
        self._status = None

    def _hold(self, now_s: float, why: Hold) -> None:
        self._safe_driver.stop(self._turns.number)
        self._gate = gate.require_neutral(self._gate, now_s, why)

    def _check_robot(self, now_s: float) -> Sentence | None:
        """Return why the robot cannot be driven; require neutral then and after a reconnection."""
        epoch = self._safe_driver.epoch
        problem = self._safe_driver.check(self._turns.number) or self._operators.on_hold
        self._gauge_hold = gauge_limits.update(
            self._gauge_hold, self._gauges, self.robot_state, now_s
        )
        problem = problem or self._gauge_hold.reason
        if problem is not None or self._safe_driver.epoch != epoch:
            self._gate = gate.require_neutral(self._gate, now_s, Hold.FAULT)
        return problem

    def _turn(self) -> TurnView:
        operator = self._turns.operator
        return TurnView(
            number=self._turns.number,
            operator=operator,
            present=operator is not None and not self._turns.is_lost(operator),
            one_way_s=self._operator_delay.one_way_s(operator),
            sees=operator is not None and self._operators.sees(operator),
            picture=self._view.clock,
            max_fraction=0.0 if operator is None else self._operators.max_fraction(operator),
            aboard=self._safe_driver.state.aboard,
        )

    def _is_operated(self, turn: TurnView) -> bool:
        """Whether an operator is connected and neither a stop nor the host keeps them from driving.

        Otherwise a person aboard who shares need not wait for an operator.
        """
        return turn.present and self.latched is None and self._operators.on_hold is None

    def _is_kept(self, now_s: float) -> bool:
        """Whether something other than the operator or their link keeps them from driving."""
        operator, stop = self._turns.operator, self.latched
        if operator is None or self._turns.is_lost(operator):
            return False
        is_stopped = stop is not None and stop.viewer != operator
        problem = self._safe_driver.problem or self._operators.on_hold or self._gauge_hold.reason
        is_blind = self._view.problem(now_s) is not None
        return is_stopped or problem is not None or self.is_taken or is_blind

    def _decide(self, turn: TurnView, now_s: float) -> Setpoint:
        was_lapsed = self._gate.lapsed
        self._gate, setpoint = gate.decide(self._gate, turn, self.latched, now_s, self._rules)
        if self._gate.lapsed and not was_lapsed:
            self._counts["commands.lapsed"] += 1
        return setpoint

    def _changes_setpoint(self, turn: TurnView, now_s: float) -> bool:
        """Whether a command has changed the set-point."""
        setpoint = self._decide(turn, now_s)
        return setpoint.twist != self._target.twist or self._safe_driver.changes_axes(setpoint.axes)

    def _limit(self) -> Sentence | None:
        """Return why the robot is slower than its operator asks.

        Only the robot knows where its bumpers are and refuses to drive further into an obstacle.
        """
        wanted = self._target
        if wanted.limit is None and not wanted.twist.is_zero and self._safe_driver.is_bumped:
            return Limit.BUMPER.value
        return wanted.limit

    def _share(self, turn: TurnView) -> float:
        """Return the fraction of the commanded speed that the limits leave, in twentieths.

        With finer steps every measurement of the link would change the reported status.
        """
        if self._target.limit is None:
            return 1.0
        share = speed.share(self._gate.command, self._target.twist, self._rules)
        if turn.aboard is not None:
            share *= turn.aboard.share
        return round(20 * share) / 20

    def _report_status(self, turn: TurnView, held: Sentence | None) -> None:
        if turn.operator is None:
            return
        reason, share = (self._limit(), self._share(turn)) if held is None else (held, 0.0)
        status = (turn.operator, self._safe_driver.is_moving, reason, share)
        if status != self._status:
            self._status = status
            for listener in self._listeners:
                listener.drive_status(*status)


def _wake(woken: asyncio.Future[None]) -> None:
    if not woken.done():
        woken.set_result(None)
