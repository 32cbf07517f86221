"""Encoding and decoding MAVLink."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from wax.robot.mavlink.codec import Codec
from wax.robot.mavlink.news import Attitude, Battery, Heartbeat, News, Parameter, Position, Speed

KEY = bytes(range(32))


class Vehicle:
    """Encodes a rover's messages."""

    def __init__(self, component: int = 1, key: bytes | None = None) -> None:
        self.mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=component)
        if key is not None:
            self.mav.signing.secret_key, self.mav.signing.sign_outgoing = key, True

    def says(self, name: str, *values: Any) -> bytes:
        message = getattr(self.mav, f"{name}_encode")(*values)
        packed: bytes = message.pack(self.mav)
        return packed


def news(data: bytes) -> list[News | None]:
    return [heard.news for heard in Codec(255, 1, None, 0).feed(data)]


def test_telemetry_is_decoded() -> None:
    """Telemetry is decoded with left positive, which is negative in MAVLink."""
    rover = Vehicle()
    assert news(
        rover.says("heartbeat", 10, 3, 128 | 1, 15, 4)
        + rover.says("param_value", b"FS_ACTION", 2.0, 9, 1, 1)
        + rover.says("vfr_hud", 0.0, 0.5, 90, 10, 0.0, 0.0)
        + rover.says("attitude", 1234, 0.0, 0.0, 0.5, 0.0, 0.0, -0.25)
        + rover.says("local_position_ned", 1234, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0)
    ) == [
        Heartbeat(10, 3, 15, is_armed=True),
        Parameter("FS_ACTION", 2.0),
        Speed(0.5),
        Attitude(-0.5, 0.25, 1234),
        Position(1.0, -2.0),
    ]


def test_a_battery_is_the_sum_of_its_cells() -> None:
    """The main battery's voltage sums all cells, even over ten; unknown values are None."""
    rover = Vehicle()
    cells = [4100, 4000, *[0xFFFF] * 8]
    assert news(
        rover.says("battery_status", 0, 0, 0, 0, cells, -1, -1, -1, 62)
        + rover.says("battery_status", 1, 0, 0, 0, cells, -1, -1, -1, 50)
        + rover.says("sys_status", 0, 0, 0, 0, 0xFFFF, -1, -1, *[0] * 6)
        + rover.says("battery_status", 0, 0, 0, 0, [4000] * 10, *[-1] * 4, 0, 0, [4000, 3900, 0, 0])
        + rover.says("battery_status", 0, 0, 0, 0, cells, *[-1] * 4, 0, 0, [0xFFFF] * 4)
    ) == [
        Battery(8.1, 0.62),
        None,
        Battery(None, None),
        Battery(47.9, None),
        Battery(8.1, None),
    ]


def test_nan_leaves_the_other_values_intact() -> None:
    """A rover without an estimate sends NaN, and only that value is unknown."""
    nan, rover = float("nan"), Vehicle()
    assert news(
        rover.says("vfr_hud", 0.0, nan, 0, 0, 0.0, 0.0)
        + rover.says("attitude", 1, 0.0, 0.0, nan, 0.0, 0.0, 0.25)
        + rover.says("attitude", 2, 0.0, 0.0, 0.5, 0.0, 0.0, nan)
        + rover.says("local_position_ned", 1, nan, 2.0, 0.0, 0.0, 0.0, 0.0)
    ) == [
        Speed(None),
        Attitude(None, -0.25, 1),
        Attitude(-0.5, None, 2),
        Position(None, -2.0),
    ]


def test_zero_volts_are_unknown() -> None:
    """Firmware without a battery monitor sends 0 V, but may still know the charge."""
    rover = Vehicle()
    assert news(
        rover.says("battery_status", 0, 0, 0, 0, [0] + [0xFFFF] * 9, -1, -1, -1, 62)
        + rover.says("sys_status", 0, 0, 0, 0, 0, -1, 50, *[0] * 6)
    ) == [Battery(None, 0.62), Battery(None, 0.5)]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize("name", [b"FS_ACTION", b"GUID_TIMEOUT", b"SYSID_MYGCS"])
def test_a_parameter_that_is_not_finite_is_ignored(name: bytes, value: float) -> None:
    """It cannot be rounded, and as NaN passes every check, it would count as a promise."""
    assert news(Vehicle().says("param_value", name, value, 9, 1, 1)) == [None]


def test_a_gimbals_heartbeat_is_not_the_rovers() -> None:
    """Only the autopilot's heartbeat counts, not those of others with its number."""
    assert news(Vehicle(component=154).says("heartbeat", 26, 8, 0, 0, 4)) == [None]


def test_only_the_right_key_is_believed() -> None:
    """A message with another key, or unsigned, is refused and counted."""
    codec = Codec(255, 1, KEY, 1_800_000_000_000)
    beat = ("heartbeat", 10, 3, 128, 15, 4)
    ours, others, nobodys = Vehicle(key=KEY), Vehicle(key=bytes(32)), Vehicle()
    others.mav.signing.timestamp = codec._mav.signing.timestamp
    ours.mav.signing.timestamp = codec._mav.signing.timestamp + 1000
    assert codec.feed(others.says(*beat)) == []
    assert codec.feed(nobodys.says(*beat)) == []
    assert codec.refused == 2
    (heard,) = codec.feed(ours.says(*beat))
    assert heard.is_signed


def test_a_signed_message_is_accepted_only_once() -> None:
    """A recorded message cannot be replayed."""
    codec, rover = Codec(255, 1, KEY, 1_800_000_000_000), Vehicle(key=KEY)
    rover.mav.signing.timestamp = codec._mav.signing.timestamp
    recorded = rover.says("heartbeat", 10, 3, 128, 15, 4)
    assert len(codec.feed(recorded)) == 1
    assert codec.feed(recorded) == []


@given(st.lists(st.binary(max_size=80), max_size=20), st.integers(0, 24))
def test_garbage_never_raises_and_is_no_news(pieces: list[bytes], cut: int) -> None:
    """After any bytes in any pieces, a heartbeat on a new connection is decoded."""
    codec = Codec(255, 1, None, 0)
    beat = Vehicle().says("heartbeat", 10, 3, 128, 15, 4)
    for piece in (*pieces, beat[:cut]):
        codec.feed(piece)
    codec.forget()
    assert [heard.news for heard in codec.feed(beat)] == [Heartbeat(10, 3, 15, is_armed=True)]
