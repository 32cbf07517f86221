"""`[turns]`: who drives, and for how long."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wax.config.table import ConfigTable


class TurnSettings(ConfigTable):
    """Who drives, and for how long."""

    turn_s: Annotated[float, Field(ge=1, le=86_400)] = 60.0
    """Seconds of one turn, after which the next in the queue drives (thesis, 3.1)."""
    grace_s: Annotated[float, Field(ge=0, le=60)] = 8.0
    """Seconds that an operator with a lost connection keeps the turn, with the robot stopped and
    the clock running. Long enough for a phone to find another network, short enough for those
    who wait."""
    join: Literal["ask", "auto"] = "ask"
    """Who queues: those who ask for it, or with "auto" everybody who opens the page, as in the
    thesis."""
    ready_s: Annotated[float, Field(ge=0, le=120)] = 0.0
    """The ready check: this many seconds before their turn the next in the queue is asked whether
    they are there. Whoever does not answer is passed over, and keeps the place once. 0 asks
    nobody."""
    idle_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    """An operator who has not driven for this many seconds loses the turn, if somebody is waiting.
    0 is never."""
    cooldown_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    """Seconds after a turn for which everybody else who waits goes first."""
    max_share_per_person: Annotated[float, Field(gt=0, le=1)] = 1.0
    """A person (a browser) who had more than this fraction of the last hour's turns lets others go
    first. 1 is no limit. Nobody is kept from an idle robot."""
    max_share_per_address: Annotated[float, Field(gt=0, le=1)] = 1.0
    """The same fraction (max_share_per_person) for everybody at one address together."""
    max_waiting_per_address: Annotated[int, Field(ge=1, le=1000)] = 50
    """How many may wait from one address."""
    invited_first: bool = True
    """Whether those with an invitation go first."""
