"""Opens the configured connection: directly by DDS, or through a rosbridge server."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.robot.ros2.dds_link import DdsLink
    from wax.robot.ros2.link import Link, Wanted
    from wax.robot.ros2.rosbridge_link import RosbridgeLink
    from wax.robot.ros2.settings import Ros2Settings


def load(settings: Ros2Settings) -> type[DdsLink | RosbridgeLink]:
    """Import the link's class; raises `ImportError` if what it needs is not installed.

    Importing here avoids loading the other transport's libraries.
    """
    if settings.transport == "rosbridge":
        from wax.robot.ros2.rosbridge_link import RosbridgeLink  # noqa: PLC0415

        return RosbridgeLink
    from wax.robot.ros2.dds_link import DdsLink  # noqa: PLC0415

    return DdsLink


def open_link(
    settings: Ros2Settings, clock: Clock, *, mark: str = "", wanted: Sequence[Wanted] = ()
) -> Link:
    """Connect; raises `DriverError`. Without a `mark` the link only subscribes."""
    return load(settings)(settings, clock, mark=mark, wanted=wanted)
