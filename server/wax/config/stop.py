"""`[stop]`: who may press Stop."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wax.config.table import ConfigTable


class StopSettings(ConfigTable):
    """Who may press Stop."""

    by: Literal["everybody", "operator"] = "everybody"
    """Who may press Stop: "everybody" who watches, or only the "operator"; the host always may. A
    Stop latches, over a restart too: nobody drives until the operator or the host releases it, and
    the host's own stop only the host. It is not an emergency stop: that is a switch in the robot's
    power line."""
    max_per_minute: Annotated[int, Field(ge=1, le=10_000)] = 6
    """How often a minute somebody may press Stop. The operator's and the host's own presses always
    count."""
    max_per_minute_per_address: Annotated[int, Field(ge=1, le=10_000)] = 20
    """How often a minute everybody at one address together may press Stop. Up to eight of these
    presses, and half of them at most, are kept for those who have watched longest from there: the
    first press a minute of each always counts."""
    release_after_s: Annotated[float, Field(ge=0, le=60)] = 3.0
    """After how many seconds the operator may release somebody else's Stop: until then a bystander
    has time to act, and pressing it again counts against no limit. The host may release it at
    once, and so may an operator who alone has pressed it."""
