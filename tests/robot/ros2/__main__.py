"""Measures set-point to robot, in JSON: `python -m tests.robot.ros2 [COUNT]`."""

from __future__ import annotations

import json
import statistics
import sys
from typing import TYPE_CHECKING

from tests.robot.ros2.base import Base, own_domain
from tests.robot.ros2.bridge import Bridge
from tests.robot.ros2.robots import key_to_wire_s, opened, ros2_settings

from wax.clock import SystemClock
from wax.robot.find_driver import make_robot

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings


def main(count: int) -> None:
    """Measure each transport, the driver in its own process."""
    domain = own_domain()
    bridge = Bridge()
    ways: dict[str, tuple[Base | Bridge, RobotSettings | None]] = {
        "CycloneDDS": (Base(domain), ros2_settings(domain)),
        "Fast DDS": (Base(domain + 1, fast=True), ros2_settings(domain + 1)),
        "rosbridge": (bridge, None),
    }
    figures = {}
    for name, (base, settings) in ways.items():
        base.start()
        at_bridge = ros2_settings(0, transport="rosbridge", rosbridge_url=bridge.url)
        driver = opened(make_robot(settings or at_bridge, SystemClock()))
        took_ms = [took_s * 1000.0 for took_s in key_to_wire_s(base, driver, count)]
        driver.close()
        base.end()
        figures[name] = {
            "n": len(took_ms),
            "median_ms": round(statistics.median(took_ms), 2),
            "p99_ms": round(took_ms[int(len(took_ms) * 0.99) - 1], 2),
            "max_ms": round(took_ms[-1], 2),
        }
    print(json.dumps(figures, indent=2))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 300)
