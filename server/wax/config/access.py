"""`[access]`: who is admitted, and when."""

from __future__ import annotations

import zoneinfo
from typing import Annotated

from pydantic import Field, field_validator

from wax.config import opening_hours
from wax.config.allowed import said
from wax.config.proxy import ProxySettings
from wax.config.table import ConfigTable


class AccessSettings(ConfigTable):
    """Who may come in, and what strangers, people without an invitation, may do. The host may
    always do everything.
    """

    strangers_watch: bool = True
    """Whether strangers may watch. If not, only those with an invitation come in."""
    strangers_hear: bool = True
    """Whether strangers hear the robot."""
    strangers_queue: bool = True
    """Whether strangers may queue and drive."""
    max_tabs: Annotated[int, Field(ge=1, le=100)] = 4
    """In how many tabs one browser may have the page open; together they have one place in the
    queue."""
    hours: list[
        Annotated[
            str,
            Field(pattern=opening_hours.PATTERN),
            said('days and times as "mon-fri 09:00-18:00"', plural="hours"),
        ]
    ] = []
    """When the robot is open. Outside of these hours only the host comes in, and the others read
    when it opens. Hours may go past midnight. Always open if the list is empty. The page offers the
    hours of the next eight weeks as a calendar to subscribe to, at /open.ics below its address.

    Example: hours = ["mon-fri 09:00-18:00", "sat 10:00-01:00"]
    """
    time_zone: str = "UTC"
    """The time zone of these hours, as "Europe/Berlin"."""
    proxy: ProxySettings = ProxySettings()

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
