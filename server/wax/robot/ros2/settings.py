"""`[robot.ros2]`."""

from __future__ import annotations

from typing import Annotated, ClassVar, Final, Literal

from pydantic import Field

from wax.config.allowed import said
from wax.config.driver_settings import DriverSettings

_NAME: Final = r"(/[A-Za-z_][A-Za-z0-9_]*)+"
_A_NAME: Final = 'a name as "/robot/cmd_vel"'
Topic = Annotated[str, Field(pattern=rf"^{_NAME}$", max_length=200), said(_A_NAME)]
MaybeTopic = Annotated[
    str, Field(pattern=rf"^({_NAME})?$", max_length=200), said(f"empty, or {_A_NAME}")
]
Address = Annotated[
    str,
    Field(pattern=r"^[A-Za-z0-9_.:-]+$", max_length=100),
    said("a host name or address", plural="addresses"),
]
Interface = Annotated[
    str,
    Field(pattern=r"^[A-Za-z0-9_.:-]*$", max_length=100),
    said('empty, or a name or address, as "wlan0"'),
]
BridgeUrl = Annotated[
    str,
    Field(pattern=r"^wss?://\S+$", max_length=300),
    said('an address as "ws://127.0.0.1:9090"'),
]

BumperType = Literal[
    "std_msgs/msg/Bool",
    "kobuki_ros_interfaces/msg/BumperEvent",
    "irobot_create_msgs/msg/HazardDetectionVector",
]
CameraType = Literal["sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"]


class Ros2Settings(DriverSettings):
    """How the robot is reached, its topics, and how long standstill is repeated."""

    TABLE: ClassVar[str] = "ros2"

    transport: Literal["dds", "rosbridge"] = "dds"
    """Straight into DDS, or by a rosbridge server where multicast does not reach."""
    domain: Annotated[int, Field(ge=0, le=232)] = 0
    """ROS_DOMAIN_ID of the robot; robots of other domains are not seen."""
    interface: Interface = ""
    """The network interface to the robot, by name or address; empty: DDS chooses."""
    peers: Annotated[list[Address], Field(max_length=16)] = []
    """Addresses to look for robots at where multicast does not reach."""
    rosbridge_url: BridgeUrl = "ws://127.0.0.1:9090"
    """The rosbridge server, for transport = "rosbridge"."""
    rosbridge_node: Topic = "/rosbridge_websocket"
    """The server's name among the nodes: its publishers are taken as ours."""
    topic: Topic = "/cmd_vel"
    """Where the robot takes its speed; with a twist_mux, an input of WAX's own."""
    stamped: bool = False
    """Whether to send TwistStamped instead of Twist, stamped by this machine's clock: a controller
    refuses what is older than its time-out, standstill too, so both clocks must agree; pictures are
    dated by their stamps then."""
    frame_id: Annotated[str, Field(max_length=100)] = "base_link"
    """The frame that a TwistStamped names."""
    reliability: Literal["reliable", "best_effort"] = "reliable"
    """What the commands offer; reliable suits every subscriber."""
    rate_hz: Annotated[int, Field(ge=20, le=100)] = 50
    """How many times a second the newest set-point is sent; controllers want it steady."""
    zeros_s: Annotated[float, Field(ge=1.5, le=30)] = 2.0
    """Seconds after a stop for which standstill is sent at rate_hz: not every robot has a time-out,
    and a network may lose messages."""
    idle_hz: Annotated[float, Field(ge=0, le=20)] = 2.0
    """How many times a second standstill is sent after zeros_s; 0 leaves the topic to others."""
    ttl_ms: Annotated[int, Field(ge=40, le=1000)] = 200
    """Milliseconds without a new set-point after which standstill is sent."""
    standby: bool = True
    """Whether a second process sends standstill when the driver's own is frozen, killed or closed;
    it takes about 40 MB."""
    timeout_s: Annotated[float, Field(ge=0, le=10)] = 0.0
    """Seconds without a command after which the receiving side stops by itself, as cmd_vel_timeout
    of diff_drive_controller (0.5); 0: never, or not known."""
    odometry: MaybeTopic = ""
    """nav_msgs/Odometry: where the robot is, and whether it moves."""
    battery: MaybeTopic = ""
    """sensor_msgs/BatteryState: its volts and its charge."""
    bumper: MaybeTopic = ""
    """The topic that tells of a collision."""
    bumper_type: BumperType = "std_msgs/msg/Bool"
    """The message type of the bumper's topic."""
    diagnostics: MaybeTopic = ""
    """diagnostic_msgs/DiagnosticArray: an ERROR there keeps the robot still."""
    camera: MaybeTopic = ""
    """The pictures for [video] source = "robot"."""
    camera_type: CameraType = "sensor_msgs/msg/CompressedImage"
    """The message type of the camera's topic; CompressedImage needs a tenth of the network."""
    reopen_s: Annotated[float, Field(ge=0.05, le=60)] = 0.5
    """Seconds before a lost or unopened connection is tried again."""
