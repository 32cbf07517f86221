"""ROS 2's messages as DDS types, with the layout of its .msg files.

In DDS, ROS 2's type names end in an underscore and are in a module ``dds_``.
"""

# No `from __future__ import annotations` here: cyclonedds reads the members' types.

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Self

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float32, float64, int32, uint8, uint32

from wax.robot.ros2 import names
from wax.robot.ros2.cdr import CdrReader

if TYPE_CHECKING:
    from collections.abc import Sequence as sequence  # noqa: N813 - what it is to who reads one

    Covariance = list[float]
else:
    from cyclonedds.idl.types import sequence

    Covariance = array[float64, 36]


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
@final
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class TwistMessage(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass
@final
class TwistStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TwistStamped_"):
    header: Header = field(default_factory=Header)
    twist: TwistMessage = field(default_factory=TwistMessage)


@dataclass
@final
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
@final
class PoseMessage(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


def _uncertain() -> list[float]:
    return [0.0] * 36


@dataclass
@final
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: PoseMessage = field(default_factory=PoseMessage)
    covariance: Covariance = field(default_factory=_uncertain)


@dataclass
@final
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: TwistMessage = field(default_factory=TwistMessage)
    covariance: Covariance = field(default_factory=_uncertain)


@dataclass
@final
class OdometryMessage(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)


@dataclass
@final
class BatteryState(IdlStruct, typename="sensor_msgs::msg::dds_::BatteryState_"):
    header: Header = field(default_factory=Header)
    voltage: float32 = 0.0
    temperature: float32 = 0.0
    current: float32 = 0.0
    charge: float32 = 0.0
    capacity: float32 = 0.0
    design_capacity: float32 = 0.0
    percentage: float32 = 0.0
    power_supply_status: uint8 = 0
    power_supply_health: uint8 = 0
    power_supply_technology: uint8 = 0
    present: bool = True
    cell_voltage: sequence[float32] = field(default_factory=list)
    cell_temperature: sequence[float32] = field(default_factory=list)
    location: str = ""
    serial_number: str = ""


@dataclass
@final
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool = False


@dataclass
@final
class BumperEvent(IdlStruct, typename="kobuki_ros_interfaces::msg::dds_::BumperEvent_"):
    bumper: uint8 = 0
    state: uint8 = 0


@dataclass
@final
class HazardDetection(IdlStruct, typename="irobot_create_msgs::msg::dds_::HazardDetection_"):
    header: Header = field(default_factory=Header)
    type: uint8 = 0


@dataclass
@final
class HazardDetectionVector(
    IdlStruct, typename="irobot_create_msgs::msg::dds_::HazardDetectionVector_"
):
    header: Header = field(default_factory=Header)
    detections: sequence[HazardDetection] = field(default_factory=list)


@dataclass
@final
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str = ""
    value: str = ""


@dataclass
@final
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8 = 0
    name: str = ""
    message: str = ""
    hardware_id: str = ""
    values: sequence[KeyValue] = field(default_factory=list)


@dataclass
@final
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header = field(default_factory=Header)
    status: sequence[DiagnosticStatus] = field(default_factory=list)


@dataclass
@final
class Image(IdlStruct, typename="sensor_msgs::msg::dds_::Image_"):
    header: Header = field(default_factory=Header)
    height: uint32 = 0
    width: uint32 = 0
    encoding: str = ""
    is_bigendian: uint8 = 0
    step: uint32 = 0
    data: sequence[uint8] = b""

    @classmethod
    def deserialize(cls, data: bytes, *_: object, **__: object) -> Self:
        """Decode it without the list of a million numbers that cyclonedds would make."""
        cdr = CdrReader(data)
        header = _header(cdr)
        height, width, encoding = cdr.uint32(), cdr.uint32(), cdr.string()
        return cls(header, height, width, encoding, cdr.uint8(), cdr.uint32(), cdr.octets())


@dataclass
@final
class CompressedImage(IdlStruct, typename="sensor_msgs::msg::dds_::CompressedImage_"):
    header: Header = field(default_factory=Header)
    format: str = ""
    data: sequence[uint8] = b""

    @classmethod
    def deserialize(cls, data: bytes, *_: object, **__: object) -> Self:
        """Decode it as an `Image` is decoded."""
        cdr = CdrReader(data)
        return cls(_header(cdr), cdr.string(), cdr.octets())


def _header(cdr: CdrReader) -> Header:
    return Header(Time(cdr.int32(), cdr.uint32()), cdr.string())


TYPES: Final = {
    names.TWIST: TwistMessage,
    names.TWIST_STAMPED: TwistStamped,
    names.ODOMETRY: OdometryMessage,
    names.BATTERY: BatteryState,
    "std_msgs/msg/Bool": Bool,
    "kobuki_ros_interfaces/msg/BumperEvent": BumperEvent,
    "irobot_create_msgs/msg/HazardDetectionVector": HazardDetectionVector,
    names.DIAGNOSTICS: DiagnosticArray,
    names.IMAGE: Image,
    names.COMPRESSED_IMAGE: CompressedImage,
}
"""Each type by the name that ROS 2 gives it."""
