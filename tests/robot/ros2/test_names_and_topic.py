"""Names in ROS 2, who is on the topic, and CycloneDDS's configuration."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET

import pytest

from wax.robot.ros2.cdr import CdrReader
from wax.robot.ros2.command_topic import OURS, STANDBY, Endpoint, SubscribersSeen, Traffic, judge
from wax.robot.ros2.cyclone_config import cyclone_config
from wax.robot.ros2.names import TWIST, TWIST_STAMPED, dds_topic, ros_type, same_type

IN_DDS = "geometry_msgs::msg::dds_::Twist_"
STAMPED_IN_DDS = "geometry_msgs::msg::dds_::TwistStamped_"
BASE = Endpoint("t", IN_DDS)
ME = Endpoint("me", IN_DDS, OURS)
OTHER = Endpoint("other", IN_DDS)


def code(traffic: Traffic) -> str | None:
    said = judge(traffic, "/cmd_vel", TWIST, {"me"})
    return None if said is None else said.code


def test_names_are_those_of_ros_2() -> None:
    """Topics begin with rt, types are in a module dds_ and end in an underscore."""
    assert dds_topic("/robot/cmd_vel") == "rt/robot/cmd_vel"
    assert ros_type(IN_DDS) == TWIST
    assert ros_type(STAMPED_IN_DDS) == TWIST_STAMPED
    assert ros_type("Some::Other") == "Some::Other"
    assert same_type("geometry_msgs/Twist", TWIST)
    assert not same_type(TWIST, TWIST_STAMPED)


@pytest.mark.parametrize(
    ("traffic", "expected"),
    [
        (Traffic((BASE,), (ME,), 1), None),
        (Traffic((), (ME,), 0), "ros2.nobody_listens"),
        (Traffic((BASE,), (ME, OTHER), 1), "ros2.other_publisher"),
        (Traffic((BASE,), (ME, Endpoint("s", BASE.type_name, STANDBY)), 1), "ros2.standby_stops"),
        (Traffic((BASE,), (Endpoint("w", BASE.type_name, OURS), ME), 1), "ros2.other_wax"),
        (Traffic((Endpoint("t", STAMPED_IN_DDS),), (ME,), 0), "ros2.wrong_type"),
        (Traffic((BASE,), (ME,), 0), "ros2.wrong_qos"),
        (Traffic((BASE, Endpoint("u", "x")), (ME,), 1), None),
        (Traffic((Endpoint("t", "geometry_msgs/Twist"),), None, None), None),
        (Traffic(None, None, None), None),
    ],
)
def test_who_is_on_the_topic(traffic: Traffic, expected: str | None) -> None:
    """Only a robot that takes our commands alone is driven; the unknown holds nobody."""
    assert code(traffic) == expected


def test_a_stranger_counts_more_than_a_standby() -> None:
    """With both on the topic, the problem is the stranger."""
    both = (OTHER, Endpoint("s", BASE.type_name, STANDBY))
    assert code(Traffic((BASE,), both, 1)) == "ros2.other_publisher"


def test_a_subscriber_that_was_not_there_is_new() -> None:
    """A newcomer is new once, even after leaving; one that leaves or has another type is not."""
    other = Endpoint("r", IN_DDS)
    again = Endpoint("t2", IN_DDS)
    strange = Endpoint("x", STAMPED_IN_DDS)
    subscribers = SubscribersSeen()
    seen = [
        subscribers.has_new(Traffic(there), TWIST)
        for there in (
            (BASE,),
            (BASE, strange),
            (BASE, other),
            (BASE, other),
            (other,),
            None,
            (other,),
            (other, again),
            (other,),
            (other, again),
        )
    ]
    assert seen == [False, False, True, False, False, False, False, True, False, True]
    subscribers.forget()
    assert not subscribers.has_new(Traffic((BASE,)), TWIST)


def test_the_loopback_interface_has_no_multicast() -> None:
    """On loopback, peers are found by their address."""
    for name in ("127.0.0.1", "lo", "localhost"):
        tree = ET.fromstring(cyclone_config(name, []))
        assert tree.findtext("Domain/General/AllowMulticast") == "false"
        assert [peer.get("address") for peer in tree.iter("Peer")] == ["127.0.0.1"]


def test_an_interface_is_named_or_addressed() -> None:
    """CycloneDDS has an attribute for each; without any it chooses itself."""
    interface = "Domain/General/Interfaces/NetworkInterface"
    named = ET.fromstring(cyclone_config("wlan0", [])).find(interface)
    addressed = ET.fromstring(cyclone_config("192.168.1.7", ["192.168.1.9"])).find(interface)
    assert named is not None
    assert named.attrib == {"name": "wlan0"}
    assert addressed is not None
    assert addressed.attrib == {"address": "192.168.1.7"}
    assert ET.fromstring(cyclone_config("", [])).find(interface) is None


def test_the_environment_comes_first() -> None:
    """CYCLONEDDS_URI stays in force except where ours overrides it."""
    assert cyclone_config("", [], "file:///etc/dds.xml").startswith("file:///etc/dds.xml,<")


@pytest.mark.parametrize("order", ["<", ">"])
def test_cdr_is_read_in_either_order(order: str) -> None:
    """Alignment counts from after the header, and strings end in a zero."""
    head = bytes([0, int(order == "<"), 0, 0])
    five, two = struct.pack(order + "I", 5), struct.pack(order + "I", 2)
    data = head + b"\x07\0\0\0" + five + b"abcd\0" + b"\0\0\0" + two + b"xy"
    cdr = CdrReader(data)
    assert (cdr.uint8(), cdr.string(), bytes(cdr.octets())) == (7, "abcd", b"xy")


@pytest.mark.parametrize(
    "data", [b"", b"\0\1", b"\0\7\0\0", b"\0\1\0\0\xff\xff\xff\xff", b"\0\1\0\0\5\0\0\0ab"]
)
def test_cdr_that_is_cut_off_is_refused(data: bytes) -> None:
    """A length beyond the message's end is an error, not a wait or a guess."""
    with pytest.raises(ValueError, match=r"CDR|cut off"):
        CdrReader(data).string()
