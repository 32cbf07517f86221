"""How old a command may be: judged by the sender's stamp, not by its arrival.

A backlog that a slow link delivers all at once is therefore stale, whole as it is. The limit
is the configured age plus the one-way delay measured at the turn's start, so that a steady
long link can be driven and one that becomes longer stops the robot. All stamps are in seconds
on the server's clock, with which the page has aligned its own. Written so that NaN is never
fresh.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.control.rules import Rules

FUTURE_S: Final = 0.050
"""Further ahead than this, and the one-way delay, the sender's clock counts as not aligned."""

MAX_ONE_WAY_S: Final = 2.0
"""No more is forgiven: nobody may drive over a line that is longer, however it is configured."""


def allowance_s(one_way_s: float | None) -> float:
    """Say how much delay is forgiven: none while it is unknown, as that stops sooner."""
    if one_way_s is None or not one_way_s > 0:
        return 0.0
    return min(one_way_s, MAX_ONE_WAY_S)


def time_to_live_s(one_way_s: float | None, rules: Rules) -> float | None:
    """Say for how long a command counts after it was sent; None where the line is too long."""
    ttl_s = rules.max_age_s + allowance_s(one_way_s)
    return ttl_s if ttl_s <= rules.max_command_age_s else None


def is_too_old(sent_s: float, now_s: float, ttl_s: float) -> bool:
    """Tell whether what was sent at `sent_s` must not move the robot at `now_s`."""
    return not now_s - sent_s <= ttl_s


def is_from_future(sent_s: float, now_s: float, *, one_way_s: float | None) -> bool:
    """Tell whether a stamp lies so far ahead that the sender's clock is not aligned."""
    return not sent_s - now_s <= FUTURE_S + allowance_s(one_way_s)
