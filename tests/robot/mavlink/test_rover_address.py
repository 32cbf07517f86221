"""MAVLink addresses as ground stations write them."""

from __future__ import annotations

import pytest

from wax.config.settings import parse as parse_settings
from wax.errors import ConfigError
from wax.robot.mavlink.address import Address, parse


@pytest.mark.parametrize(
    ("url", "address"),
    [
        ("/dev/ttyACM0", Address("serial", "/dev/ttyACM0")),
        (
            "/dev/serial/by-id/usb-ArduPilot_X:Y",
            Address("serial", "/dev/serial/by-id/usb-ArduPilot_X:Y"),
        ),
        ("COM3", Address("serial", "COM3")),
        ("udpin:0.0.0.0:14550", Address("udpin", "0.0.0.0", 14550)),
        ("udp:0.0.0.0:14550", Address("udpin", "0.0.0.0", 14550)),
        ("udpout:rover.local:14550", Address("udpout", "rover.local", 14550)),
        ("tcp:[::1]:5760", Address("tcp", "::1", 5760)),
    ],
)
def test_an_address_is_parsed(url: str, address: Address) -> None:
    """A path is a serial port, anything else a host and a port."""
    assert parse(url) == address


@pytest.mark.parametrize(
    "url",
    ["udpin:14550", "tcp:rover:", "tcp:rover:99999", "udpin::14550", "ws:a:1", "udpin:a:b"],
)
def test_an_invalid_address_is_refused(url: str) -> None:
    """Loading the configuration fails, and the error lists what is possible."""
    tree = {"robot": {"driver": "mavlink", "mavlink": {"url": url}}}
    with pytest.raises(ConfigError, match=r"robot\.mavlink\.url: .*(possible are|write it as)"):
        parse_settings(tree, "wax.toml")
