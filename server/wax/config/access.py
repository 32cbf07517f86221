"""`[access]`: who is admitted, and when."""

from __future__ import annotations

import zoneinfo
from typing import Annotated

from pydantic import Field, field_validator

from wax.config import opening_hours
from wax.config.table import ConfigTable


class AccessSettings(ConfigTable):
    """`[access]`: who is admitted, and what strangers may do."""

    strangers_watch: bool = True
    strangers_hear: bool = True
    strangers_queue: bool = True
    max_tabs: Annotated[int, Field(ge=1, le=100)] = 4
    hours: list[
        Annotated[
            str,
            Field(
                pattern=opening_hours.PATTERN,
                description='days and times as "mon-fri 09:00-18:00"',
                json_schema_extra={"plural": "hours"},
            ),
        ]
    ] = []
    time_zone: str = "UTC"

    @field_validator("time_zone")
    @classmethod
    def _is_known(cls, name: str) -> str:
        known = zoneinfo.available_timezones()
        if name == "UTC" or name in known:
            return name
        if not known:
            raise ValueError(
                f"{name} needs time zone data, which this machine lacks: install Python's package"
                " tzdata, or leave the key out for UTC"
            )
        raise ValueError(f"there is no time zone {name}; one is Europe/Berlin")
