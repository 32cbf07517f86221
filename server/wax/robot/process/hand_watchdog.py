"""Decides whose set-points reach the driver, the server's or the person's aboard (pure).

The server's messages go through the `DriverWatchdog` as usual; the resulting calls pass only while
the hand control lets an operator drive (`wax.control.local_hand`). Whenever the driving person
changes, the robot is stopped for at least one period.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.control import local_hand, ramp
from wax.control.local_hand import HandState
from wax.control.reasons import NO_HAND
from wax.driver.interface import STANDSTILL
from wax.robot.process.driver_watchdog import SILENT, Apply, SetControl, StopDriver
from wax.robot.process.pipe_messages import Move

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.control.local_hand import HandRules
    from wax.driver.hand import HandReading
    from wax.driver.interface import Aboard, Twist
    from wax.robot.process.driver_watchdog import Call, DriverWatchdog
    from wax.robot.process.pipe_messages import Message
    from wax.sentence import Sentence

HAND_COUNTS: Final = ("driver_hand_takes", "driver_hand_stops", "driver_hand_losses")

OPERATOR_LOST_S: Final = 0.5
"""After this long without an operator's set-point the person drives alone. Shorter silences stop
the robot too, but the stick keeps its meaning."""


class HandWatchdog:
    """Used like a `DriverWatchdog`; `handle_readings` handles the hand control's readings.

    While the person drives, none of the server's motion reaches the driver, not even its stops. A
    Stop on a page need not stop them: they are there, feel what the robot does, and have a Stop of
    their own, whereas any viewer may press the page's Stop, late and seeing less. If that ended the
    person's driving, anybody could leave them stranded on a crossing. The page's Stop is latched
    all the same: no operator drives until it is released. A fault of the robot or the control does
    stop the person, and then the control must be at rest first.
    """

    def __init__(self, watchdog: DriverWatchdog, rules: HandRules) -> None:
        self._watchdog = watchdog
        self._rules = rules
        self._hand = HandState()
        self._twist = STANDSTILL
        """The newest set-point that was ramped here: the person's own or a shared one."""
        self._applied_s = -math.inf
        self._heard_s = -math.inf
        self._counts = dict.fromkeys(HAND_COUNTS, 0)

    @property
    def aboard(self) -> Aboard:
        """The person aboard, as the robot's state reports them."""
        return local_hand.report(self._hand, self._rules)

    @property
    def is_stopped(self) -> bool:
        """Whether the person's Stop is in force, even if their control is lost."""
        return self._hand.is_stopped

    @property
    def is_in_use(self) -> bool:
        """Whether the person drives, or the robot still slows down afterwards."""
        return self._hand.mode == "hand" or not self._twist.is_zero

    @property
    def problem(self) -> Sentence | None:
        """Why the robot is held; while the person drives, the server's silence does not hold it."""
        match self._hand.mode:
            case "lost":
                return NO_HAND
            case "free":
                return self._watchdog.problem
            case _:
                return None

    @property
    def holds(self) -> int:
        return self._watchdog.holds

    @property
    def counts(self) -> dict[str, int]:
        return self._watchdog.counts | self._counts

    @property
    def silent_at_s(self) -> float:
        return self._watchdog.silent_at_s

    def recall_stop(self) -> None:
        """Start with the person's Stop in force; call it before the first reading."""
        self._hand = HandState(is_stopped=True)

    def handle_readings(self, readings: Iterable[HandReading], now_s: float) -> tuple[Call, ...]:
        """Handle readings of the hand control, oldest first; call it before the other methods."""
        calls: tuple[Call, ...] = ()
        is_operator_heard = now_s - self._heard_s < OPERATOR_LOST_S
        for reading in readings:
            hand = local_hand.accept(
                self._hand, reading, now_s, self._rules, is_operator_heard=is_operator_heard
            )
            calls = (*calls, *self._follow(hand, now_s))
        return (*calls, *self._look(now_s))

    def lose_hand(self, now_s: float) -> tuple[Call, ...]:
        """Hold the robot at once because the control is known to be gone."""
        return self._follow(local_hand.lose(self._hand), now_s)

    def handle(self, message: Message, now_s: float) -> tuple[Call, ...]:
        """Handle a message of the server."""
        looked = self._look(now_s)
        calls = self._watchdog.handle(message, now_s)
        if isinstance(message, Move) and any(isinstance(call, Apply) for call in calls):
            self._heard_s = now_s if message.operated else -math.inf
        return (*looked, *self._passed(calls, now_s))

    def repeat(self, now_s: float) -> tuple[Call, ...]:
        """Repeat the current set-point, whosever it is."""
        calls = (*self._look(now_s), *self._passed(self._watchdog.repeat(now_s), now_s))
        return calls if self._hand.mode == "free" else (*calls, self._own(now_s))

    def tick(self, now_s: float) -> tuple[Call, ...]:
        """Stop the server's motion if the server is silent, and the robot if the control is."""
        return (*self._look(now_s), *self._passed(self._watchdog.tick(now_s), now_s))

    def handle_invalid(self, now_s: float) -> tuple[Call, ...]:
        """Hold the server's motion because of an invalid message."""
        return self._passed(self._watchdog.handle_invalid(now_s), now_s)

    def abandoned(self, now_s: float) -> tuple[Call, ...]:
        """Hold the server's motion because the server is dead, without waiting for silence."""
        self._heard_s = -math.inf
        return self._passed(self._watchdog.hold(SILENT, now_s), now_s)

    def failed(self, now_s: float) -> tuple[Call, ...]:
        """Hold the robot because the driver raised."""
        self._stand(now_s)
        return self._watchdog.failed(now_s)

    def hold(self, problem: Sentence | None, now_s: float) -> tuple[Call, ...]:
        """Stop the robot; neither earlier messages nor a hand on the control move it again."""
        self._stand(now_s)
        return self._watchdog.hold(problem, now_s)

    def _look(self, now_s: float) -> tuple[Call, ...]:
        return self._follow(local_hand.tick(self._hand, now_s, self._rules), now_s)

    def _follow(self, hand: HandState, now_s: float) -> tuple[Call, ...]:
        """Stop the robot when the mode changes; earlier set-points never count afterwards."""
        before, self._hand = self._hand, hand
        if hand.mode == before.mode:
            return ()
        self._counts["driver_hand_takes"] += hand.mode == "hand"
        self._counts["driver_hand_stops"] += hand.mode == "stopped"
        self._counts["driver_hand_losses"] += hand.mode == "lost"
        calls = self._watchdog.hold(None, now_s)
        if before.mode == "hand" and hand.mode == "pause" and self._rules.soft_braking:
            # The person let go: an occupied chair slows down at the configured rate.
            return tuple(call for call in calls if isinstance(call, SetControl))
        self._twist, self._applied_s = STANDSTILL, now_s
        return calls

    def _stand(self, now_s: float) -> None:
        self._hand = local_hand.disarm(self._hand, now_s)
        self._twist, self._applied_s = STANDSTILL, now_s

    def _passed(self, calls: tuple[Call, ...], now_s: float) -> tuple[Call, ...]:
        """Return the server's calls that may reach the driver."""
        match self._hand.mode:
            case "free":
                return tuple(self._shared(call, now_s) for call in calls)
            case "hand":
                return tuple(call for call in calls if _is_harmless(call))
            case _:
                slows_down = not self._twist.is_zero
                stops = () if slows_down else tuple(c for c in calls if isinstance(c, StopDriver))
                return (*stops, *(call for call in calls if _is_harmless(call)))

    def _shared(self, call: Call, now_s: float) -> Call:
        """Scale a set-point by the fraction that the person lets through."""
        if not self._rules.shares:
            return call
        if isinstance(call, Apply):
            part = local_hand.share(self._hand, self._rules)
            return self._ramped(call.twist.scaled(part), call.turn, now_s)
        if isinstance(call, StopDriver):
            self._twist = STANDSTILL
        return call

    def _own(self, now_s: float) -> Apply:
        target = local_hand.twist(self._hand, self._rules, self._watchdog.limits)
        return self._ramped(target, self._watchdog.turn, now_s)

    def _ramped(self, target: Twist, turn: int, now_s: float) -> Apply:
        """Ramp towards `target`; a late tick takes no larger step than two ticks would."""
        after_s = min(max(0.0, now_s - self._applied_s), 2 * self._rules.period_s)
        self._twist = ramp.towards(target, self._twist, after_s, self._rules, soft=True)
        self._applied_s = now_s
        return Apply(self._twist, turn)


def _is_harmless(call: Call) -> bool:
    """Whether the call only lights, sounds or releases, which disturbs nobody's driving."""
    return isinstance(call, SetControl) and (call.is_release or not call.moves)
