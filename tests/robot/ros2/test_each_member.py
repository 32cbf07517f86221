"""Each member of a message counts for itself: a wrong one leaves the others known."""

from __future__ import annotations

import copy
import json
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final

import cv2
import numpy as np
import pytest
from tests.robot.ros2.robots import ros2_settings

from wax.config.controls import GaugeSettings
from wax.control.gauge_limits import GaugeHold, update
from wax.driver.interface import Limits, Pose
from wax.robot.ros2.conversation import Ros2Conversation
from wax.robot.ros2.images import to_bgr
from wax.robot.ros2.senses import RosSenses
from wax.robot.ros2.settings import Ros2Settings

if TYPE_CHECKING:
    from collections.abc import Iterator

REMOVED: Final = object()
WRONG: Final[tuple[Any, ...]] = (
    REMOVED,
    None,
    "words",
    True,
    [],
    {},
    [[7]],
    float("nan"),
    float("inf"),
    10**400,
)

VECTOR: Final = {"x": 0.0, "y": 0.0, "z": 0.0}
COVARIANCE: Final = [0.1] * 36
MESSAGES: Final[dict[str, dict[str, Any]]] = {
    "odometry": {
        "header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "odom"},
        "child_frame_id": "base",
        "pose": {
            "pose": {
                "position": {"x": 1.0, "y": 2.0, "z": 0.0},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
            },
            "covariance": COVARIANCE,
        },
        "twist": {
            "twist": {"linear": VECTOR | {"x": 0.3}, "angular": VECTOR},
            "covariance": COVARIANCE,
        },
    },
    "battery": {
        "header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": ""},
        "voltage": 12.1,
        "temperature": 20.0,
        "current": -1.0,
        "percentage": 0.5,
        "present": True,
        "cell_voltage": [4.0],
    },
    "bumper": {"detections": [{"header": {"frame_id": "a"}, "type": 0}, {"type": 1}]},
    "diagnostics": {
        "header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": ""},
        "status": [
            {"level": 0, "name": "lidar", "message": "OK", "values": [{"key": "a", "value": "b"}]},
            {"level": 2, "name": "motors", "message": "hot", "hardware_id": "7", "values": []},
        ],
    },
}
Path = tuple[Any, ...]


def places(value: Any, path: Path = ()) -> Iterator[Path]:
    if not isinstance(value, dict | list):
        return
    for key, one in value.items() if isinstance(value, dict) else enumerate(value[:2]):
        yield (*path, key)
        yield from places(one, (*path, key))


def spoilt(kind: str, path: Path, wrong: Any) -> Any:
    message = copy.deepcopy(MESSAGES[kind])
    holder: Any = message
    for key in path[:-1]:
        holder = holder[key]
    if wrong is REMOVED:
        del holder[path[-1]]
    else:
        holder[path[-1]] = wrong
    return json.loads(json.dumps(message), object_hook=lambda found: SimpleNamespace(**found))


def known(kind: str, message: Any) -> dict[str, Any]:
    senses = RosSenses()
    senses.handle_message(kind, message, 1.0)
    return {
        "pose": senses.pose(1.0),
        "moving": senses.moving(1.0),
        "volts": senses.battery_v,
        "share": senses.battery_fraction,
        "bumped": senses.bumpers,
        "fault": senses.fault(1.0),
    }


NEEDS: Final[dict[str, dict[str, tuple[str, ...]]]] = {
    "odometry": {
        "pose": ("pose.pose.position.x", "pose.pose.position.y", "pose.pose.orientation"),
        "moving": ("twist.twist.linear.x",),
    },
    "battery": {"volts": ("voltage",), "share": ("percentage",)},
    "bumper": {"bumped": ("detections.1.type",)},
    "diagnostics": {"fault": ("status.1.level", "status.1.name", "status.1.message")},
}
"""What is known from a complete message, and the members that each needs."""


def touches(path: Path, needed: str) -> bool:
    spoils = ".".join(map(str, path)).split(".")
    parts = needed.split(".")
    shorter = min(len(spoils), len(parts))
    return spoils[:shorter] == parts[:shorter]


@pytest.mark.parametrize("kind", MESSAGES)
def test_the_other_members_stay_known(kind: str) -> None:
    """If a member is missing, null or wrong, all that does not need it is still known."""
    whole = known(kind, spoilt(kind, ("extra",), 7))
    told = {name for name, value in whole.items() if value}
    assert told == set(NEEDS[kind])
    for path in places(MESSAGES[kind]):
        for wrong in WRONG:
            if wrong is REMOVED and isinstance(path[-1], int):
                continue  # the others would move up
            now = known(kind, spoilt(kind, path, wrong))
            for name, needed in NEEDS[kind].items():
                if not any(touches(path, one) for one in needed):
                    assert now[name] == whole[name], (path, wrong)


@pytest.mark.parametrize("wrong", WRONG, ids=lambda value: repr(value)[:9])
@pytest.mark.parametrize("name", ["voltage", "percentage"])
def test_a_missing_gauge_that_stops_holds_by_its_name(name: str, wrong: Any) -> None:
    """The link stays up; only the gauge that needs the missing number holds the robot."""
    talk = Ros2Conversation(ros2_settings(0).own(Ros2Settings), Limits(0.5, 1.0))
    talk.opened(0.0)
    talk.judged(None, alone=True)
    talk.handle_message("battery", spoilt("battery", (name,), wrong), 1.0)
    state = talk.state(1.0)
    assert (state.connected, state.epoch) == (True, 1)
    for gauge, needs in (("battery_v", "voltage"), ("battery_fraction", "percentage")):
        held = update(GaugeHold(), [GaugeSettings(name=gauge, stop_below=0.1)], state, 1.0).reason
        assert (held.code if held else None) == ("gauge.untold" if needs == name else None)


@pytest.mark.parametrize(
    ("part", "place", "pose", "moving"),
    [
        ("pose", 0, None, False),
        ("pose", 35, None, False),
        ("twist", 0, Pose(1.0, 2.0, 0.0), None),
        ("twist", 35, Pose(1.0, 2.0, 0.0), None),
        ("twist", 14, Pose(1.0, 2.0, 0.0), False),
    ],
)
def test_a_negative_variance_means_not_measured(
    part: str, place: int, pose: Pose | None, moving: bool | None
) -> None:
    """By -1 in ROS; the zero with it is not standstill."""
    covariance = [-1.0 if at == place else 0.1 for at in range(36)]
    message = spoilt("odometry", (part, "covariance"), covariance)
    message.twist.twist.linear.x = 0.0
    now = known("odometry", message)
    assert (now["pose"], now["moving"]) == (pose, moving)


def test_a_quaternion_of_zeros_is_no_heading() -> None:
    """A robot without an orientation sends zeros; its motion is still known."""
    message = spoilt("odometry", ("pose", "pose", "orientation", "w"), 0.0)
    now = known("odometry", message)
    assert (now["pose"], now["moving"]) == (None, True)


@pytest.mark.parametrize("wrong", WRONG, ids=lambda value: repr(value)[:9])
def test_a_press_without_its_bumper_counts(wrong: Any) -> None:
    """A press without its place is known, and so is its end."""
    senses = RosSenses()
    event = {} if wrong is REMOVED else {"bumper": wrong}
    senses.handle_message("bumper", SimpleNamespace(**event, state=1), 1.0)
    assert senses.bumpers
    senses.handle_message("bumper", SimpleNamespace(**event, state=0), 1.0)
    assert senses.bumpers == 0


@pytest.mark.parametrize("member", ["format", "header", "step", "is_bigendian"])
@pytest.mark.parametrize("wrong", [REMOVED, None, 0])
def test_a_picture_needs_only_what_its_pixels_need(member: str, wrong: Any) -> None:
    """Members that the pixels do not depend on may be missing or wrong."""
    raw = {"encoding": "bgr8", "width": 2, "height": 1, "step": 6, "is_bigendian": 0}
    message = {"header": {}, "format": "", "data": bytes(range(6))} | raw
    message.pop(member) if wrong is REMOVED else message.update({member: wrong})
    assert np.array_equal(to_bgr(SimpleNamespace(**message)).ravel(), np.arange(6))


@pytest.mark.parametrize("wrong", [REMOVED, None, 7])
def test_a_compressed_picture_is_read_without_its_format(wrong: Any) -> None:
    """The octets themselves say their format."""
    octets = cv2.imencode(".png", np.full((2, 2, 3), 9, np.uint8))[1].tobytes()
    form = {} if wrong is REMOVED else {"format": wrong}
    assert to_bgr(SimpleNamespace(data=octets, **form)).max() == 9


def test_octets_may_be_a_list_of_numbers() -> None:
    """Some bridges do not use base64; a list of anything else is refused."""
    picture = {"encoding": "mono8", "width": 2, "height": 1, "step": 2}
    assert to_bgr(SimpleNamespace(data=[7, 9], **picture))[0, :, 0].tolist() == [7, 9]
    for wrong in ([7, 256], [7, None], [7, "9"]):
        with pytest.raises(ValueError, match=r".+"):
            to_bgr(SimpleNamespace(data=wrong, **picture))
