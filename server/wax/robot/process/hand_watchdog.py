"""The person aboard above the server: whose set-points reach the driver (pure).

The server's messages go through the `DriverWatchdog` as ever; what comes of them passes only while
the hand control leaves the robot to an operator (`wax.control.local_hand`). Between two who drive
there is always a stop, for one period at least.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.control import local_hand, ramp
from wax.control.local_hand import HandState
from wax.control.reasons import NO_HAND
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.process.driver_watchdog import SILENT, Apply, SetControl, StopDriver
from wax.robot.process.pipe_messages import Move

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.control.local_hand import HandRules
    from wax.driver.hand import HandReading
    from wax.driver.interface import Aboard, Limits
    from wax.robot.process.driver_watchdog import Call, DriverWatchdog
    from wax.robot.process.pipe_messages import Message
    from wax.sentence import Sentence

HAND_COUNTS: Final = ("driver_hand_takes", "driver_hand_stops", "driver_hand_losses")

OPERATOR_LOST_S: Final = 0.5
"""Without a set-point of an operator for this long there is none to share with. Shorter silences
stop the robot too, but the stick keeps its meaning."""


class HandWatchdog:
    """Used as a `DriverWatchdog`; `feel` takes what the hand control says.

    While the person drives, nothing of the server's reaches the driver, its stops included. A Stop
    on a page is no doubt in which they should stand: they are there, feel what the robot does, and
    have a Stop of their own, whereas everybody who watches may press that one, late, and seeing
    less. If it ended the person's driving, anybody could leave them stranded on a crossing. It is
    latched all the same: no operator drives until it is released. Everything that holds the robot
    for a fault of its own, or of the control, does stop them, and then the control must be seen at
    rest first.
    """

    def __init__(self, watchdog: DriverWatchdog, limits: Limits, rules: HandRules) -> None:
        self._watchdog = watchdog
        self._limits = limits
        self._rules = rules
        self._hand = HandState()
        self._twist = STANDSTILL
        """The newest set-point of those that are ramped here: the person's own, or shared ones."""
        self._applied_s = -math.inf
        self._heard_s = -math.inf
        self._counts = dict.fromkeys(HAND_COUNTS, 0)

    @property
    def aboard(self) -> Aboard:
        """The person aboard, for the robot's state."""
        return local_hand.report(self._hand, self._rules)

    @property
    def is_stopped(self) -> bool:
        """Whether the person's Stop is in force, though their control may be lost."""
        return self._hand.is_stopped

    @property
    def is_in_use(self) -> bool:
        """Whether the person drives, or still slows down after it."""
        return self._hand.mode == "hand" or not self._twist.is_zero

    @property
    def problem(self) -> Sentence | None:
        """Why the robot is held; the server's silence is no matter while the person drives."""
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
        """Begin with the person's Stop in force; call it before anything was felt."""
        self._hand = HandState(is_stopped=True)

    def feel(self, readings: Iterable[HandReading], now_s: float) -> tuple[Call, ...]:
        """Take what the hand control says, oldest first, before anything else of this moment."""
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

    def hear(self, message: Message, now_s: float) -> tuple[Call, ...]:
        """Handle a message of the server."""
        looked = self._look(now_s)
        calls = self._watchdog.hear(message, now_s)
        if isinstance(message, Move) and any(isinstance(call, Apply) for call in calls):
            self._heard_s = now_s if message.operated else -math.inf
        return (*looked, *self._passed(calls, now_s))

    def beat(self, now_s: float) -> tuple[Call, ...]:
        """Repeat the current set-point, whosever it is."""
        calls = (*self._look(now_s), *self._passed(self._watchdog.beat(now_s), now_s))
        return calls if self._hand.mode == "free" else (*calls, self._own(now_s))

    def watch(self, now_s: float) -> tuple[Call, ...]:
        """Stop what the server has asked for if it is silent, and the robot if the control is."""
        return (*self._look(now_s), *self._passed(self._watchdog.watch(now_s), now_s))

    def garbage(self, now_s: float) -> tuple[Call, ...]:
        """Hold what the server asks for because of an invalid message."""
        return self._passed(self._watchdog.garbage(now_s), now_s)

    def abandoned(self, now_s: float) -> tuple[Call, ...]:
        """Hold what the server has asked for because it is dead, without waiting for silence."""
        self._heard_s = -math.inf
        return self._passed(self._watchdog.hold(SILENT, now_s), now_s)

    def failed(self, now_s: float) -> tuple[Call, ...]:
        """Hold the robot because the driver raised."""
        self._stand(now_s)
        return self._watchdog.failed(now_s)

    def hold(self, problem: Sentence | None, now_s: float) -> tuple[Call, ...]:
        """Stop the robot; nothing sent before moves it again, and no hand that was on it."""
        self._stand(now_s)
        return self._watchdog.hold(problem, now_s)

    def _look(self, now_s: float) -> tuple[Call, ...]:
        return self._follow(local_hand.tick(self._hand, now_s, self._rules), now_s)

    def _follow(self, hand: HandState, now_s: float) -> tuple[Call, ...]:
        """Stop the robot where its driver changes; what was asked for before never counts after."""
        before, self._hand = self._hand, hand
        if hand.mode == before.mode:
            return ()
        self._counts["driver_hand_takes"] += hand.mode == "hand"
        self._counts["driver_hand_stops"] += hand.mode == "stopped"
        self._counts["driver_hand_losses"] += hand.mode == "lost"
        calls = self._watchdog.hold(None, now_s)
        if before.mode == "hand" and hand.mode == "pause" and self._rules.soft_braking:
            # Let go: a chair with somebody in it slows down at the rate that it is given.
            return tuple(call for call in calls if isinstance(call, SetControl))
        self._twist, self._applied_s = STANDSTILL, now_s
        return calls

    def _stand(self, now_s: float) -> None:
        self._hand = local_hand.disarm(self._hand, now_s)
        self._twist, self._applied_s = STANDSTILL, now_s

    def _passed(self, calls: tuple[Call, ...], now_s: float) -> tuple[Call, ...]:
        """Return what may reach the driver of what the server has asked for."""
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
        """Scale a set-point by what the person lets pass."""
        if not self._rules.shares:
            return call
        if isinstance(call, Apply):
            part = local_hand.share(self._hand, self._rules)
            return self._ramped(_scaled(call.twist, part), call.turn, now_s)
        if isinstance(call, StopDriver):
            self._twist = STANDSTILL
        return call

    def _own(self, now_s: float) -> Apply:
        target = local_hand.twist(self._hand, self._rules, self._limits)
        return self._ramped(target, self._watchdog.turn, now_s)

    def _ramped(self, target: Twist, turn: int, now_s: float) -> Apply:
        """Move on towards `target`; a late beat takes no larger step than two would."""
        after_s = min(max(0.0, now_s - self._applied_s), 2 * self._rules.period_s)
        self._twist = ramp.towards(target, self._twist, after_s, self._rules, soft=True)
        self._applied_s = now_s
        return Apply(self._twist, turn)


def _is_harmless(call: Call) -> bool:
    """Whether it only lights, sounds or lets go: that disturbs nobody who drives."""
    return isinstance(call, SetControl) and (call.is_release or not call.moves)


def _scaled(twist: Twist, share: float) -> Twist:
    return Twist(twist.linear_mps * share, twist.angular_rps * share)
