"""Converts names of topics and types between ROS 2 and DDS (pure)."""

from __future__ import annotations

TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
ODOMETRY = "nav_msgs/msg/Odometry"
BATTERY = "sensor_msgs/msg/BatteryState"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"


def dds_topic(topic: str) -> str:
    """Return a topic's DDS name: ``/cmd_vel`` is ``rt/cmd_vel``."""
    return "rt" + topic


def ros_type(name: str) -> str:
    """Return ROS 2's name of a DDS type; a type that is not ROS 2's stays unchanged.

    ``geometry_msgs::msg::dds_::Twist_`` is ``geometry_msgs/msg/Twist``.
    """
    parts = name.split("::")
    if len(parts) == 4 and parts[2] == "dds_" and parts[3].endswith("_"):
        return f"{parts[0]}/{parts[1]}/{parts[3][:-1]}"
    return name


def same_type(one: str, other: str) -> bool:
    """Whether two ROS names mean one type; rosbridge also uses ROS 1's short form."""
    return _short(one) == _short(other)


def _short(name: str) -> str:
    return name.replace("/msg/", "/")
