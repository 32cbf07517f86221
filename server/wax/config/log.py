"""`[log]`: how events are logged."""

from __future__ import annotations

from typing import Literal

from wax.config.table import ConfigTable


class LogSettings(ConfigTable):
    """`[log]`."""

    format: Literal["text", "json"] = "text"
    level: Literal["debug", "info", "warning", "error"] = "info"
