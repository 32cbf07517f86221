"""`[stop]`: who may press Stop."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wax.config.table import ConfigTable


class StopSettings(ConfigTable):
    """`[stop]`: who may press Stop."""

    by: Literal["everybody", "operator"] = "everybody"
    max_per_minute: Annotated[int, Field(ge=1, le=10_000)] = 6
    max_per_minute_per_address: Annotated[int, Field(ge=1, le=10_000)] = 20
    release_after_s: Annotated[float, Field(ge=0, le=60)] = 3.0
