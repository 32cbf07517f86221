"""The base of a driver's own table in the configuration, `[robot.TABLE]`."""

from __future__ import annotations

from typing import ClassVar

from wax.config.table import ConfigTable


class DriverSettings(ConfigTable):
    """Settings of one driver; name the subclass `Settings` inside the driver's class.

    A field has its range in its type and its purpose in the docstring below it, or as description::

        class Settings(DriverSettings):
            TABLE = "tank"

            bus: Annotated[int, Field(ge=0, le=7)] = 1
            \"\"\"The number of its bus.\"\"\"

    The table `[robot.tank]` is validated when the configuration is loaded, `wax config` shows it,
    and the driver gets it from `RobotSettings.own`, with defaults for missing keys. TOML has
    strings, numbers, true and false, lists and tables: other types are refused.
    """

    TABLE: ClassVar[str]
