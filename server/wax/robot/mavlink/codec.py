"""Encodes and decodes MAVLink, by pymavlink: orders become frames, frames become `news`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from pymavlink.dialects.v20 import common as mavlink

from wax.robot.mavlink.mapping import BODY_FRAME, VELOCITY_AND_YAW_RATE
from wax.robot.mavlink.news import (
    AUTOPILOT,
    Attitude,
    Battery,
    HeardMessage,
    Heartbeat,
    News,
    Parameter,
    Position,
    Speed,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.robot.mavlink.mapping import Sticks, Velocity

OWN_COMPONENT: Final = 190
"""MAV_COMP_ID_MISSIONPLANNER, the number of a ground station."""

_SIGNING_BEGAN_S: Final = 1_420_070_400
_TICKS_PER_S: Final = 100_000
"""Signatures count 10 µs since the year 2015."""
_UNKNOWN_MV: Final = 0xFFFF
_ANY_INDEX: Final = -1
_SIGNED: Final = 0x01

TELEMETRY: Final[dict[int, type[Speed | Attitude | Position | Battery]]] = {
    mavlink.MAVLINK_MSG_ID_VFR_HUD: Speed,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: Attitude,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: Position,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: Battery,
}
"""The messages requested from the rover, and what they report."""


class Codec:
    """Both directions of one line; with a `key` we sign messages and refuse unsigned ones.

    `damaged` counts invalid messages, `refused` those without a valid signature.
    """

    def __init__(self, own_system: int, system: int, key: bytes | None, wall_ms: int) -> None:
        self._system = system
        self._mav = mavlink.MAVLink(None, srcSystem=own_system, srcComponent=OWN_COMPONENT)
        self._mav.robust_parsing = True
        self.damaged = self.refused = 0
        if key is not None:
            signing = self._mav.signing
            signing.secret_key, signing.sign_outgoing = key, True
            # From here it only rises, even over a reconnection.
            signing.timestamp = round((wall_ms / 1000.0 - _SIGNING_BEGAN_S) * _TICKS_PER_S)

    def forget(self) -> None:
        """Drop the beginning of a message whose end was lost with the line."""
        self._mav.buf, self._mav.buf_index = bytearray(), 0

    def feed(self, data: bytes) -> list[HeardMessage]:
        """Decode the next bytes; return the messages, leaving out and counting damaged ones."""
        heard = []
        for message in self._mav.parse_buffer(data) or ():
            if message.get_type() == "BAD_DATA":
                is_unsigned = message.reason == "Invalid signature"
                self.refused += is_unsigned
                self.damaged += not is_unsigned
                continue
            read = _READERS.get(message.get_msgId())
            heard.append(
                HeardMessage(
                    system=message.get_srcSystem(),
                    component=message.get_srcComponent(),
                    news=None if read is None else read(message),
                    is_signed=bool(message.get_header().incompat_flags & _SIGNED),
                )
            )
        return heard

    def heartbeat(self) -> bytes:
        return self._pack(
            self._mav.heartbeat_encode(
                mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE
            )
        )

    def ask_parameter(self, name: str) -> bytes:
        return self._pack(
            self._mav.param_request_read_encode(
                self._system, AUTOPILOT, name.encode("ascii"), _ANY_INDEX
            )
        )

    def ask_telemetry(self, message_id: int, rate_hz: float) -> bytes:
        return self._pack(
            self._mav.command_long_encode(
                self._system,
                AUTOPILOT,
                mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
                0,
                message_id,
                1e6 / rate_hz,
                *(0.0,) * 5,
            )
        )

    def sticks(self, pushed: Sticks) -> bytes:
        return self._pack(
            self._mav.manual_control_encode(self._system, 0, pushed.y, pushed.z, 0, 0)
        )

    def velocity(self, wanted: Velocity, now_s: float) -> bytes:
        return self._pack(
            self._mav.set_position_target_local_ned_encode(
                round(now_s * 1000.0) & 0xFFFFFFFF,
                self._system,
                AUTOPILOT,
                BODY_FRAME,
                VELOCITY_AND_YAW_RATE,
                *(0.0,) * 3,
                wanted.vx_mps,
                *(0.0,) * 6,
                wanted.yaw_rate_rps,
            )
        )

    def _pack(self, message: Any) -> bytes:
        packed: bytes = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        return packed


def _heartbeat(message: Any) -> Heartbeat | None:
    if message.get_srcComponent() != AUTOPILOT and message.type != mavlink.MAV_TYPE_GCS:
        return None  # a gimbal, a camera or a companion computer of the same system
    return Heartbeat(
        kind=message.type,
        autopilot=message.autopilot,
        mode=message.custom_mode,
        is_armed=bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED),
    )


def _parameter(message: Any) -> Parameter | None:
    if not math.isfinite(message.param_value):
        return None  # as if not reported: it is requested again
    return Parameter(message.param_id, message.param_value)


def _speed(message: Any) -> Speed:
    return Speed(_known(message.groundspeed))


def _attitude(message: Any) -> Attitude:
    return Attitude(_known(0.0 - message.yaw), _known(0.0 - message.yawspeed), message.time_boot_ms)


def _position(message: Any) -> Position:
    return Position(_known(message.x), _known(0.0 - message.y))


def _known(value: float) -> float | None:
    """Return None for NaN, which a rover without an estimate sends."""
    return value if math.isfinite(value) else None


def _battery(message: Any) -> Battery | None:
    if message.id != 0:
        return None  # a second battery
    # Ten cells and four extensions, for which firmware without them sends 0 or, wrongly, unknown.
    cells_mv = [one for one in (*message.voltages, *message.voltages_ext) if one != _UNKNOWN_MV]
    return Battery(_volts(sum(cells_mv)), _fraction(message))


def _system_status(message: Any) -> Battery:
    volts_mv = message.voltage_battery
    return Battery(_volts(0 if volts_mv == _UNKNOWN_MV else volts_mv), _fraction(message))


def _volts(millivolts: int) -> float | None:
    """Return None for 0, which firmware without a battery monitor sends."""
    return millivolts / 1000.0 if millivolts else None


def _fraction(message: Any) -> float | None:
    percent = message.battery_remaining
    return None if percent < 0 else min(1.0, percent / 100.0)


_READERS: Final[dict[int, Callable[[Any], News | None]]] = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: _heartbeat,
    mavlink.MAVLINK_MSG_ID_PARAM_VALUE: _parameter,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: _speed,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: _attitude,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: _position,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: _battery,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: _system_status,
}
