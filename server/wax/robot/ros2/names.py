"""Names of topics and types, as ROS 2 writes them and as they are in DDS (pure)."""

from __future__ import annotations

TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
ODOMETRY = "nav_msgs/msg/Odometry"
BATTERY = "sensor_msgs/msg/BatteryState"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"


def dds_topic(topic: str) -> str:
    """``/cmd_vel`` is ``rt/cmd_vel`` in DDS."""
    return "rt" + topic


def ros_type(name: str) -> str:
    """Return how ROS 2 writes a type of DDS; one that is not of ROS 2 stays as it is.

    ``geometry_msgs::msg::dds_::Twist_`` is ``geometry_msgs/msg/Twist``.
    """
    parts = name.split("::")
    if len(parts) == 4 and parts[2] == "dds_" and parts[3].endswith("_"):
        return f"{parts[0]}/{parts[1]}/{parts[3][:-1]}"
    return name


def same_type(one: str, other: str) -> bool:
    """Whether two names of ROS mean one type; rosbridge writes ROS 1's short form, too."""
    return _short(one) == _short(other)


def _short(name: str) -> str:
    return name.replace("/msg/", "/")
