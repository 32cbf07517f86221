"""`[records]`: what is recorded of people and turns."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.table import ConfigTable


class RecordSettings(ConfigTable):
    """`[records]`: what is recorded, and for how long."""

    enabled: bool = True
    path: str = ""
    keep_days: Annotated[float, Field(ge=0.01, le=3650)] = 30.0
