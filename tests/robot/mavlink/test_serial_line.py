"""A stop on a serial line does not wait for the output buffer to empty."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from wax.robot.mavlink.codec import Codec
from wax.robot.mavlink.line import MAY_WAIT_BYTES, MavlinkLine, open_line
from wax.robot.mavlink.mapping import Velocity
from wax.robot.mavlink.settings import MavlinkSettings

SETTINGS = MavlinkSettings.model_validate({"url": "/dev/radio"})


class Port:
    """A port that sends nothing."""

    def __init__(self, *_: object, **__: object) -> None:
        self.waits = b""
        self.knows = True

    @property
    def out_waiting(self) -> int:
        if not self.knows:
            raise OSError("not supported")
        return len(self.waits)

    def write(self, data: bytes) -> None:
        self.waits += data

    def reset_output_buffer(self) -> None:
        self.waits = b""


@pytest.fixture
def port(monkeypatch: pytest.MonkeyPatch) -> Port:
    port = Port()
    monkeypatch.setattr("serial.Serial", lambda *_, **__: port)
    return port


@pytest.fixture
def line(port: Port) -> MavlinkLine:
    return open_line(SETTINGS)


def told(data: bytes, key: bytes | None) -> list[float]:
    """Return the speeds that a rover decodes."""
    heard = Codec(1, 255, key, 1_700_000_000_000)._mav.parse_buffer(data) or ()
    kind = mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED
    return [message.vx for message in heard if message.get_msgId() == kind]


@pytest.mark.parametrize("key", [None, bytes(range(32))])
def test_a_stop_overtakes_what_waits(port: Port, line: MavlinkLine, key: bytes | None) -> None:
    """Wherever the message being sent is cut off, the rover decodes the stop."""
    codec = Codec(255, 1, key, 1_800_000_000_000)
    ahead = codec.velocity(Velocity(0.5, 0.0), 1.0)
    for taken in range(len(ahead)):
        port.waits = ahead * 20
        line.stop(codec.velocity(Velocity(0.0, 0.0), 1.0))
        assert len(port.waits) <= MAY_WAIT_BYTES
        assert told(ahead[:taken] + port.waits, key) == [0.0]


def test_a_nearly_empty_buffer_is_kept(port: Port, line: MavlinkLine) -> None:
    """A short wait does no harm, and the stop is written only once."""
    line.write(bytes(MAY_WAIT_BYTES))
    line.stop(b"stop")
    assert port.waits == bytes(MAY_WAIT_BYTES) + b"stop"


def test_a_port_that_cannot_report_its_buffer_is_written_to(port: Port, line: MavlinkLine) -> None:
    """It does not count as lost."""
    port.knows = False
    line.stop(b"stop")
    assert port.waits == b"stop"
