"""`[records]`: what is recorded of people and turns."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.table import ConfigTable


class RecordSettings(ConfigTable):
    """Who came, who drove, who pressed Stop and how links were, for `wax records`. Addresses are
    shortened.
    """

    enabled: bool = True
    """Whether anything is recorded. Without records, bans and used invitations last until the
    server ends."""
    path: str = ""
    """The file, an SQLite database. "" is records.db in [server] state_dir."""
    keep_days: Annotated[float, Field(ge=0.01, le=3650)] = 30.0
    """Days after which records are deleted."""
