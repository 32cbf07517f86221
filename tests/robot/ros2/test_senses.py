"""The robot's messages become a state, and invalid ones change nothing."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.driver.interface import Pose
from wax.robot.ros2.senses import FAULT_S, ODOMETRY_S, RosSenses


def message(values: object) -> Any:
    return json.loads(json.dumps(values), object_hook=lambda found: SimpleNamespace(**found))


def odometry(
    *, z: object = 0.0, w: object = 1.0, v: float = 0.0, turning: float = 0.0, aside: float = 0.0
) -> Any:
    return message(
        {
            "pose": {
                "pose": {
                    "position": {"x": 1, "y": 2, "z": 0},
                    "orientation": {"x": 0, "y": 0, "z": z, "w": w},
                }
            },
            "twist": {
                "twist": {
                    "linear": {"x": v, "y": aside, "z": 0},
                    "angular": {"x": 0, "y": 0, "z": turning},
                }
            },
        }
    )


def status(level: object, name: str = "motors", words: str = "hot") -> Any:
    return message({"status": [{"level": level, "name": name, "message": words}]})


@pytest.mark.parametrize(
    ("degrees", "heading"), [(0, 0.0), (90, math.pi / 2), (-90, -math.pi / 2), (45, math.pi / 4)]
)
def test_a_heading_comes_from_the_quaternion(degrees: float, heading: float) -> None:
    """The heading is from the x axis, left positive."""
    senses = RosSenses()
    half = math.radians(degrees) / 2
    senses.handle_message("odometry", odometry(z=math.sin(half), w=math.cos(half)), 1.0)
    pose = senses.pose(1.0)
    assert isinstance(pose, Pose)
    assert pose.heading_rad == pytest.approx(heading)


@pytest.mark.parametrize(
    ("v", "turning", "aside", "moves"),
    [
        (0.0, 0.0, 0.0, False),
        (0.005, 0.01, 0.005, False),
        (-0.05, 0, 0, True),
        (0, 0.1, 0, True),
        (0, 0, -0.05, True),
    ],
)
def test_motion_is_more_than_noise(v: float, turning: float, aside: float, moves: bool) -> None:
    """The odometry of a standing robot is never quite zero."""
    senses = RosSenses()
    senses.handle_message("odometry", odometry(v=v, turning=turning, aside=aside), 1.0)
    assert senses.moving(1.0) is moves


def test_old_odometry_expires() -> None:
    """After a silence, motion and pose are unknown."""
    senses = RosSenses()
    senses.handle_message("odometry", odometry(v=1.0), 1.0)
    assert senses.moving(1.0 + ODOMETRY_S) is None
    assert senses.pose(1.0 + ODOMETRY_S) is None


@pytest.mark.parametrize(
    ("voltage", "percentage", "volts", "share"),
    [
        (12.1, 0.5, 12.1, 0.5),
        (12.1, 55.0, 12.1, 0.55),
        (float("nan"), float("nan"), None, None),
        (12.1, -1.0, 12.1, None),
    ],
)
def test_a_battery_value_may_be_unknown(
    voltage: float, percentage: float, volts: float | None, share: float | None
) -> None:
    """NaN or a negative charge is unknown; percents become the fraction that ROS specifies."""
    senses = RosSenses()
    senses.handle_message("battery", message({"voltage": voltage, "percentage": percentage}), 1.0)
    assert (senses.battery_v, senses.battery_fraction) == (volts, share)


def test_each_bumper_has_its_bit() -> None:
    """Releasing one bumper leaves another pressed."""
    senses = RosSenses()
    senses.handle_message("bumper", message({"bumper": 0, "state": 1}), 1.0)
    senses.handle_message("bumper", message({"bumper": 2, "state": 1}), 1.0)
    assert senses.bumpers == 0b101
    senses.handle_message("bumper", message({"bumper": 0, "state": 0}), 1.0)
    assert senses.bumpers == 0b100


@pytest.mark.parametrize("level", [2, "\x02", "Ag=="])
def test_an_error_is_a_fault(level: object) -> None:
    """An ERROR, however its octet is encoded, is a fault until its part reports otherwise."""
    senses = RosSenses()
    senses.handle_message("diagnostics", status(level), 1.0)
    assert senses.fault(1.0) == "motors: hot"
    senses.handle_message("diagnostics", status(0, "other"), 1.0)
    assert senses.fault(1.0) == "motors: hot"
    senses.handle_message("diagnostics", status(1), 1.0)
    assert senses.fault(1.0) is None


def test_a_fault_that_is_not_repeated_expires() -> None:
    """A node that has reported a fault and ended keeps nobody from driving."""
    senses = RosSenses()
    senses.handle_message("diagnostics", status(2), 1.0)
    assert senses.fault(1.0 + FAULT_S - 0.1)
    assert senses.fault(1.0 + FAULT_S) is None


def test_faults_do_not_pile_up() -> None:
    """Of a thousand failing parts not all are stored."""
    senses = RosSenses()
    for number in range(1000):
        senses.handle_message("diagnostics", status(2, f"part {number}", "x" * 10_000), 1.0)
    fault = senses.fault(1.0)
    assert fault is not None
    assert len(fault) <= 200
    assert len(senses._faults) <= 256


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                (
                    *("pose", "position", "orientation", "twist", "linear", "angular", "x", "w"),
                    *("status", "level", "name", "message", "data", "state", "bumper"),
                    *("detections", "voltage", "percentage", "z"),
                )
            ),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)


@given(st.sampled_from(["odometry", "battery", "bumper", "diagnostics"]), JSON)
@examples(400)
def test_an_invalid_message_never_raises(kind: str, values: object) -> None:
    """With any JSON the state stays valid."""
    senses = RosSenses()
    senses.handle_message(kind, message(values), 1.0)
    assert senses.pose(1.0) is None or senses.moving(1.0) is not None
    assert 0 <= senses.bumpers <= 255
    assert senses.battery_fraction is None or 0.0 <= senses.battery_fraction <= 1.0
    assert senses.fault(1.0) is None or isinstance(senses.fault(1.0), str)


def test_an_invalid_message_is_counted() -> None:
    """Odometry with an infinite orientation changes nothing, and is counted."""
    senses = RosSenses()
    senses.handle_message("odometry", odometry(z=float("inf")), 1.0)
    assert senses.pose(1.0) is None
    assert senses.invalid == 1


@pytest.mark.parametrize("levels", [1, 100, 5000])
@pytest.mark.parametrize(("where", "fault"), [("name", "?: hot"), ("message", "motors: ?")])
def test_a_tree_in_place_of_a_text_is_counted(levels: int, where: str, fault: str) -> None:
    """The error counts without its text, and a tree of any depth is not written out."""
    tree: Any = SimpleNamespace()
    for _ in range(levels):
        tree = SimpleNamespace(inner=tree)
    error = SimpleNamespace(**{"level": 2, "name": "motors", "message": "hot", where: tree})
    senses = RosSenses()
    senses.handle_message("diagnostics", SimpleNamespace(status=[error]), 1.0)
    assert (senses.fault(1.0), senses.invalid) == (fault, 1)


def test_an_empty_level_is_counted() -> None:
    """A level without an octet does not raise."""
    senses = RosSenses()
    senses.handle_message("diagnostics", status(""), 1.0)
    assert (senses.fault(1.0), senses.invalid) == (None, 1)
