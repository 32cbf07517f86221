"""The table `[robot.mavlink]`."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from wax.config.driver_settings import DriverSettings
from wax.robot.mavlink.address import check, parse

LEAST_HZ: Final = 20.0
FRAME_BYTES: Final = {"guided": 65, "manual": 23, "acro": 23}
"""A set-point's length on the line in each mode."""
SIGNATURE_BYTES: Final = 13
_BITS_PER_BYTE: Final = 10
"""On a serial line, including start and stop bits."""
_PERCENT: Final = 70
"""The share of a serial line for set-points: the rest is for heartbeats and requests."""


class MavlinkSettings(DriverSettings):
    """A ground rover or boat with ArduPilot, at the other end of a MAVLink line."""

    TABLE: ClassVar[str] = "mavlink"

    url: Annotated[str, Field(min_length=1)] = "/dev/ttyACM0"
    """The line, as ground stations write it: a serial port, udpin:ADDRESS:PORT to listen there,
    udpout:ADDRESS:PORT or tcp:ADDRESS:PORT to go to the rover or its router."""
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 115_200
    """Bits a second of a serial port; telemetry radios have 57600."""
    system: Annotated[int, Field(ge=1, le=255)] = 1
    """The rover's number, its SYSID_THISMAV; all others on the line are ignored."""
    own_system: Annotated[int, Field(ge=1, le=255)] = 255
    """WAX's own number; the rover obeys only the one in its SYSID_MYGCS."""
    mode: Literal["guided", "manual", "acro"] = "guided"
    """The mode in which the rover must be. guided: speeds in m/s and rad/s, which the rover keeps
    by its own sensors (it needs a position, and has its own time-out); manual: throttle and
    steering as shares of max_linear_mps and max_angular_rps, for one without a position; acro:
    the same, with the rover holding the turn rate. None moves an omni frame sideways: of our
    messages ArduPilot reads only throttle and steering, and of a velocity only its length."""
    failsafe_s: Annotated[float, Field(ge=0.0, le=60.0)] = 0.0
    """Seconds without WAX after which the rover must stop by itself. Its parameters (GUID_TIMEOUT,
    FS_GCS_ENABLE, FS_GCS_TIMEOUT, FS_TIMEOUT, FS_ACTION) are read at each connection; if they
    promise less, nobody drives. 0: nothing is demanded, only warned of."""
    signing_key: str = ""
    """The file with the key for signed messages: 32 bytes, or 64 hexadecimal digits; nobody else
    may read it (chmod 600). With a key, what is not signed with it is ignored. Empty: not
    signed."""
    command_hz: Annotated[float, Field(ge=LEAST_HZ, le=100.0)] = 50.0
    """How many times a second a set-point is sent at most, and repeated in motion. On a serial
    port, set-points may fill 70 % of what baud lets through."""
    telemetry_hz: Annotated[float, Field(ge=1.0, le=50.0)] = 10.0
    """How many times a second the rover is asked to tell its speed, attitude and position."""
    moving_mps: Annotated[float, Field(ge=0.01, le=1.0)] = 0.1
    """The speed in metres a second from which the rover counts as moving; satellites alone measure
    it with noise."""
    reopen_s: Annotated[float, Field(ge=0.05, le=60.0)] = 0.5
    """Seconds before a line that was lost is opened again."""

    @field_validator("url")
    @classmethod
    def _is_a_line(cls, url: str) -> str:
        return check(url)

    @model_validator(mode="after")
    def _is_not_the_rover(self) -> Self:
        if self.system != self.own_system:
            return self
        raise ValueError(
            f"system and own_system are both {self.system}, but the rover needs a number of its"
            " own: set system to its SYSID_THISMAV and own_system to its SYSID_MYGCS"
        )

    @model_validator(mode="after")
    def _leaves_room_for_a_stop(self) -> Self:
        frame_bytes = FRAME_BYTES[self.mode] + (SIGNATURE_BYTES if self.signing_key else 0)
        frame_bits = frame_bytes * _BITS_PER_BYTE
        needs_baud = math.ceil(self.command_hz * frame_bits * 100 / _PERCENT)
        if parse(self.url).kind != "serial" or self.baud >= needs_baud:
            return self
        most_hz = self.baud * _PERCENT // (100 * frame_bits)
        raise ValueError(
            f"command_hz = {self.command_hz:g} is too often for baud = {self.baud}, where a stop"
            f" would wait behind older set-points: set baud to {needs_baud} or more, here and at"
            " the rover's port" + (f", or command_hz to {most_hz}" if most_hz >= LEAST_HZ else "")
        )
