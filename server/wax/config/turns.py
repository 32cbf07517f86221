"""`[turns]`: who drives, and for how long."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wax.config.table import ConfigTable


class TurnSettings(ConfigTable):
    """`[turns]`: who drives, and for how long."""

    turn_s: Annotated[float, Field(ge=1, le=86_400)] = 60.0
    grace_s: Annotated[float, Field(ge=0, le=60)] = 8.0
    join: Literal["ask", "auto"] = "ask"
    ready_s: Annotated[float, Field(ge=0, le=120)] = 0.0
    idle_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    cooldown_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    max_share_per_person: Annotated[float, Field(gt=0, le=1)] = 1.0
    max_share_per_address: Annotated[float, Field(gt=0, le=1)] = 1.0
    max_waiting_per_address: Annotated[int, Field(ge=1, le=1000)] = 50
    invited_first: bool = True
