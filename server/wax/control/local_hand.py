"""The hand control of the person aboard, who outranks every operator. Pure.

- Touching the control takes over at once (``hand``). After its release the robot stands still for a
  pause; then an operator may drive again (``free``), starting from neutral.
- The person's Stop (``stopped``) holds everybody, the person too, until they ask to resume with the
  control at rest. Nobody else can release it.
- A control that is silent or sends impossible values is ``lost``: nobody drives, since the person
  could neither take over nor stop.
- A control moves nothing until it has been at rest once, at the start and after each loss or stop;
  a stick that is stuck, or held throughout, must be released first. Until then, and during the
  pause that follows, nobody drives (``pause``).
- Where the person `shares`, the stick does not take over while an operator's commands arrive:
  pushed ahead, it lets that fraction of the operator's set-point through; at rest, sideways or
  back, it lets none through. Without an operator, or once their commands cease, it drives, after it
  has been at rest once.

The driver process applies these rules, even without the server; the gate obeys the resulting mode.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Self

from wax.driver.checks import within
from wax.driver.interface import STANDSTILL, Aboard, Twist

if TYPE_CHECKING:
    from wax.config.local import LocalSettings
    from wax.config.robot import RobotSettings
    from wax.driver.hand import HandReading
    from wax.driver.interface import Ask, HandMode, Limits

_TO_PASS: Final = ("free", "pause", "hand")
"""The modes in which the control answers and no stop is latched."""


@dataclass(frozen=True, slots=True)
class HandRules:
    """Constant while the driver process runs.

    `silence_s` is how long a control may be silent, `pause_s` how long the robot stands still after
    the control is released. Deflections up to `dead_zone` count as rest. The person may use
    `max_fraction` of the robot's speed; the rest is as in `Rules`.
    """

    shares: bool
    silence_s: float
    pause_s: float
    dead_zone: float
    max_fraction: float
    period_s: float
    acceleration_mps2: float
    acceleration_rps2: float
    soft_braking: bool
    braking_mps2: float
    braking_rps2: float

    @classmethod
    def of(cls, local: LocalSettings, robot: RobotSettings, period_s: float) -> Self:
        """Gather the rules from the configuration; `period_s` is the set-point interval."""
        return cls(
            shares=local.stick == "shares",
            silence_s=local.silence_ms / 1000,
            pause_s=local.pause_s,
            dead_zone=local.dead_zone,
            max_fraction=local.max_fraction,
            period_s=period_s,
            acceleration_mps2=robot.max_linear_acceleration_mps2,
            acceleration_rps2=robot.max_angular_acceleration_rps2,
            soft_braking=robot.soft_braking,
            braking_mps2=robot.braking_mps2,
            braking_rps2=robot.braking_mps2 / robot.lever_m,
        )


@dataclass(frozen=True, slots=True)
class HandState:
    """The state of the control; `asked` and `asks` are as in `Aboard`."""

    mode: HandMode = "lost"
    reading: HandReading | None = None
    """The newest reading, None while the control is lost."""
    since_s: float = -math.inf
    """When the mode began, or when the control was last touched in the pause."""
    is_armed: bool = False
    """Whether the control has been at rest since it was last disarmed."""
    is_stopped: bool = False
    """Whether the person's Stop is latched."""
    shares: bool = False
    """Whether the person shares the driving with an operator whose commands arrive."""
    asked: Ask | None = None
    asks: int = 0


def accept(
    state: HandState,
    reading: HandReading,
    now_s: float,
    rules: HandRules,
    *,
    is_operator_heard: bool = True,
) -> HandState:
    """Return the state after a reading; an old or future one is ignored, except for its Stop.

    `is_operator_heard` says whether an operator's set-points still arrive.
    """
    state = tick(state, now_s, rules)
    if reading.stop:
        state = _stopped(state, now_s)  # however late it comes, and whatever else is wrong with it
    newest_s = -math.inf if state.reading is None else state.reading.at_s
    if not (newest_s <= reading.at_s and 0.0 <= now_s - reading.at_s < rules.silence_s):
        return state
    if not reading.is_in_range:
        return lose(state)
    is_touched = touches(reading, rules)
    pressed = _pressed(state, reading)
    if pressed is not None:
        state = replace(state, asked=pressed, asks=state.asks + 1)
    is_released = pressed == "go_on" and not is_touched
    is_stopped = reading.stop or (state.is_stopped and not is_released)
    shares = rules.shares and is_operator_heard
    # The stick means something else when sharing than when driving: it must be at rest between.
    is_armed = not is_touched or (state.is_armed and shares == state.shares) or _drives(state)
    heard = replace(
        state,
        reading=reading,
        is_stopped=is_stopped,
        is_armed=is_armed and not is_stopped,
        shares=shares,
    )
    return _in_mode(heard, _mode(heard, is_touched=is_touched), now_s, is_touched=is_touched)


def tick(state: HandState, now_s: float, rules: HandRules) -> HandState:
    """Detect silence and the end of the pause; call it at least once per set-point."""
    if state.reading is None:
        return state
    if not now_s - state.reading.at_s < rules.silence_s:
        return lose(state)
    if (
        state.mode == "pause"
        and not touches(state.reading, rules)
        and now_s - state.since_s >= rules.pause_s
    ):
        return replace(state, mode="free", since_s=now_s)
    return state


def lose(state: HandState) -> HandState:
    """Mark the control as lost; a latched stop stays latched."""
    return replace(state, mode="lost", reading=None, is_armed=False)


def disarm(state: HandState, now_s: float) -> HandState:
    """Require the control to be at rest first, as after a fault of the robot."""
    mode: HandMode = "pause" if state.mode == "hand" else state.mode
    return replace(state, mode=mode, is_armed=False, since_s=now_s)


def touches(reading: HandReading, rules: HandRules) -> bool:
    """Whether a hand is on the control."""
    deflection = max(abs(reading.linear), abs(reading.angular), abs(reading.lateral))
    return reading.is_held or deflection > rules.dead_zone


def twist(state: HandState, rules: HandRules, limits: Limits) -> Twist:
    """Return the person's own set-point, within the limits; standstill if they do not drive."""
    if state.mode != "hand" or state.reading is None:
        return STANDSTILL
    asked = Twist(
        _beyond(state.reading.linear, rules) * limits.linear_mps,
        _beyond(state.reading.angular, rules) * limits.angular_rps,
        _beyond(state.reading.lateral, rules) * limits.lateral_mps,
    )
    return within(asked, limits).scaled(rules.max_fraction)


def share(state: HandState, rules: HandRules) -> float:
    """Return the fraction of an operator's set-point that is let through, 0 to 1."""
    if state.mode != "free" or state.reading is None:
        return 0.0
    return max(0.0, _beyond(state.reading.linear, rules)) if rules.shares else 1.0


def report(state: HandState, rules: HandRules) -> Aboard:
    """Return what the server needs to know about the person aboard."""
    return Aboard(state.mode, round(share(state, rules), 2), state.asked, state.asks)


def _pressed(state: HandState, reading: HandReading) -> Ask | None:
    """Return the request whose button went down with this reading.

    A button that was down when the control reconnected does not count: it may be stuck.
    """
    before = state.reading
    return reading.ask if before is not None and before.ask != reading.ask else None


def _stopped(state: HandState, now_s: float) -> HandState:
    """Latch the person's Stop, even while the control's other inputs are ignored."""
    state = replace(state, is_stopped=True, is_armed=False)
    return state if state.mode == "lost" else _in_mode(state, "stopped", now_s)


def _drives(state: HandState) -> bool:
    return state.mode == "hand"


def _mode(heard: HandState, *, is_touched: bool) -> HandMode:
    """Return the next mode; `heard.mode` is still the previous one."""
    if heard.is_stopped:
        return "stopped"
    if heard.mode not in _TO_PASS:
        return "pause"
    if is_touched:
        if heard.is_armed and (_drives(heard) or not heard.shares):
            return "hand"
        return "free" if heard.mode == "free" and heard.is_armed else "pause"
    return "pause" if _drives(heard) else heard.mode


def _in_mode(
    state: HandState, mode: HandMode, now_s: float, *, is_touched: bool = False
) -> HandState:
    goes_on = mode == state.mode and not (mode == "pause" and is_touched)
    return state if goes_on else replace(state, mode=mode, since_s=now_s)


def _beyond(deflection: float, rules: HandRules) -> float:
    """Return the deflection beyond the dead zone, rescaled to -1…1."""
    share_beyond = max(0.0, abs(deflection) - rules.dead_zone) / (1.0 - rules.dead_zone)
    return math.copysign(share_beyond, deflection)
