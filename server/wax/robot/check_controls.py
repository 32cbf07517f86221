"""Checks that the robot has the controls that the configuration names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.controls import ControlSettings
    from wax.driver.interface import Limits


def check_controls(limits: Limits, name: str, controls: Sequence[ControlSettings]) -> None:
    """Raise `ConfigError` for a control that the driver `name` does not know."""
    known = limits.controls
    for at, control in enumerate(controls):
        if control.name in known:
            continue
        if not known:
            raise ConfigError(
                f"controls: the driver {name} has no controls; leave the tables [[controls]] out,"
                " or use a driver that names some in its limits"
            )
        raise ConfigError(
            f"controls[{at}].name: got {control.name!r}; the driver {name} has {', '.join(known)}"
        )
