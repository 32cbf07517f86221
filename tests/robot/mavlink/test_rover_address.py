"""Where a rover is, as ground stations write it."""

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
def test_a_line_is_understood(url: str, address: Address) -> None:
    """A path is a serial port, the rest has an address and a port."""
    assert parse(url) == address


@pytest.mark.parametrize(
    "url",
    ["udpin:14550", "tcp:rover:", "tcp:rover:99999", "udpin::14550", "ws:a:1", "udpin:a:b"],
)
def test_what_is_no_line_is_refused_with_a_sentence(url: str) -> None:
    """It is refused when the configuration is loaded, and says what is possible."""
    tree = {"robot": {"driver": "mavlink", "mavlink": {"url": url}}}
    with pytest.raises(ConfigError, match=r"robot\.mavlink\.url: .*(possible are|write it as)"):
        parse_settings(tree, "wax.toml")
