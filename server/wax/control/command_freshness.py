"""How old a command may be: judged by the sender's timestamp, not by its arrival.

A backlog that a slow link delivers all at once is therefore stale. The limit is the configured
age plus the one-way delay, as `wax.control.operator_delay` estimates it: a link with a steady long
delay can be driven over, and one whose delay grows stops the robot. All timestamps are in seconds
on the server's clock, to which the page has aligned its own. NaN is never fresh.

A page may claim any time. So each command quotes the newest beat that its sender has received
(`wax.control.beats`), and counts as sent no later than the beat's own time plus the one-way delay
plus `HELD_S`. By the server's clock alone a command therefore moves nothing later than
`max_age_s` + 2 · one-way delay + `HELD_S` after its sender last received a beat. A page that claims
a longer delay raises that no further than `max_command_age_s` allows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.control.rules import Rules

FUTURE_S: Final = 0.050
"""A timestamp further ahead than this plus the one-way delay means a misaligned clock."""

HELD_S: Final = 0.35
"""How old the operator's newest beat may be: beats go out every 0.1 s, and two may be lost."""

CALM_HELD_S: Final = 1.0 + HELD_S
"""The same for everybody else: their beats go out once a second."""

MAX_ONE_WAY_S: Final = 2.0
"""The largest delay that is ever allowed for, whatever is configured."""


def allowance_s(one_way_s: float | None) -> float:
    """Return how much delay to allow for: none while it is unknown, because that stops sooner."""
    if one_way_s is None or not one_way_s > 0:
        return 0.0
    return min(one_way_s, MAX_ONE_WAY_S)


def time_to_live_s(one_way_s: float | None, rules: Rules) -> float | None:
    """Return a command's time-to-live, from when it was sent; None if the delay is too long."""
    ttl_s = rules.max_age_s + allowance_s(one_way_s)
    return ttl_s if ttl_s <= rules.max_command_age_s else None


def credible_sent_s(
    sent_s: float, heard_s: float, now_s: float, *, one_way_s: float | None, held_s: float = HELD_S
) -> float:
    """Return the send time to believe of a message that claims `sent_s` and has come by `now_s`.

    `heard_s` is when the newest beat that its sender had received was sent, minus infinity if none.
    """
    return min(sent_s, now_s, heard_s + allowance_s(one_way_s) + held_s)


def is_too_old(sent_s: float, now_s: float, ttl_s: float) -> bool:
    """Whether a command sent at `sent_s` must not move the robot at `now_s`."""
    return not now_s - sent_s <= ttl_s


def is_from_future(sent_s: float, now_s: float, *, one_way_s: float | None) -> bool:
    """Whether a timestamp is so far ahead that the sender's clock cannot be aligned."""
    return not sent_s - now_s <= FUTURE_S + allowance_s(one_way_s)
