"""Which connection: straight into DDS, or by a rosbridge server."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.robot.ros2.link import Link, Wanted
    from wax.robot.ros2.settings import Ros2Settings


def check_transport(settings: Ros2Settings) -> None:
    """Raise `ImportError` if what the transport needs is not installed."""
    if settings.transport == "dds":
        import cyclonedds  # noqa: F401, PLC0415


def open_link(
    settings: Ros2Settings, clock: Clock, *, mark: str = "", wanted: Sequence[Wanted] = ()
) -> Link:
    """Connect; raises `DriverError`. Without a `mark` it only subscribes.

    The libraries are imported here, so that nobody waits for those of the other transport.
    """
    if settings.transport == "rosbridge":
        from wax.robot.ros2.rosbridge_link import RosbridgeLink  # noqa: PLC0415

        return RosbridgeLink(settings, clock, mark=mark, wanted=wanted)
    from wax.robot.ros2.dds_link import DdsLink  # noqa: PLC0415

    return DdsLink(settings, clock, mark=mark, wanted=wanted)
