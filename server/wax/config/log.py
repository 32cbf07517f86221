"""`[log]`: how events are logged."""

from __future__ import annotations

from typing import Literal

from wax.config.table import ConfigTable


class LogSettings(ConfigTable):
    """What the server writes to its log."""

    format: Literal["text", "json"] = "text"
    """How events are written to standard error: for people, or one JSON object a line for
    machines."""
    level: Literal["debug", "info", "warning", "error"] = "info"
    """The least important events to write. With "debug" also each step of the event loop above 2
    ms, with its stack, which costs a tenth of a core."""
