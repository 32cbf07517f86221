"""Which sources are mutated, and which tests must catch the mutants.

A mutant is run against its own tests in the order given here, until the first failure: the quick
ones come first. Only these tests count, so each module is held by the tests written for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]

ACCEPTED: Final = 0.95
"""At least this fraction of all mutants must be caught."""

CORE: Final = "server/firmware/wax/src/core"

_LONG: Final = ("properties", "black_channel", "hand_over")
"""Parts of the names of slow tests, which try many cases."""

_GATE: Final = ("test_gate", "test_lying_page", "test_gate_properties", "test_black_channel")
_LOOP: Final = ("test_control_loop", "test_controls_loop")
_CONTROL: Final[dict[str, tuple[str, ...]]] = {
    "beats": ("test_beats",),
    "command": _GATE,
    "command_freshness": ("test_command_freshness", *_GATE),
    "driving_view": ("test_driving_view",),
    "gate": ("test_picture_clock", *_GATE),
    "local_hand": ("test_rules", "test_local_hand", "test_local_hand_properties"),
    "loop": _LOOP,
    "loop_timer": ("test_loop_timer", *_LOOP),
    "operator_delay": ("test_operator_delay", *_LOOP),
    "picture_clock": ("test_picture_clock",),
    "ramp": ("test_ramp", *_LOOP),
    "reasons": (*_GATE, *_LOOP),
    "rules": ("test_rules", *_LOOP),
    "safe_driver": ("test_safe_driver", *_LOOP),
    "speed": ("test_speed", *_GATE),
    "stop_latch": ("test_stop_latch", *_LOOP),
    "stopping_distance": ("test_stopping_distance", "test_speed"),
    "turns": ("test_turns", "test_turn_rules", "test_fairness", "test_turns_properties"),
    "video_freshness": ("test_video_freshness", "test_picture_clock", *_GATE),
}
_ROBOT: Final[dict[str, tuple[str, ...]]] = {
    "hand/line": ("test_hand_line",),
    "process/driver_watchdog": ("process/test_driver_watchdog",),
    "process/hand_watchdog": ("process/test_hand_watchdog", "process/test_hand_black_channel"),
    "process/pipe_messages": ("process/test_pipe_messages",),
    "serial/frames": ("test_serial_frames", "test_dialects"),
    "serial/frames_dialect": ("test_frames_dialect", "test_frames_sideways", "test_dialects"),
    "line/core": ("test_line_core",),
    "line/setpoints": ("test_setpoints",),
    "serial/bytes_dialect": ("test_dialects",),
    "serial/odometry": ("test_odometry",),
    "serial/text_dialect": ("test_text_dialect",),
    "serial/text_lines": ("test_text_lines",),
    "wheels": ("test_wheels",),
}
_OTHERS: Final[dict[str, tuple[str, ...]]] = {
    "driver/checks": ("driver/test_checks", "robot/test_wheels", "robot/test_setpoints"),
    "commands/proof/measure": ("commands/proof/test_measure",),
    "commands/proof/verdict": ("commands/proof/test_verdict",),
    "rtc/link_monitor": ("rtc/test_link_monitor",),  # the link's delay, which commands are granted
    "session/stop_budget": (
        *("session/test_stop_budget", "session/test_session_rooms", "session/test_house_acts"),
        "session/test_kept_state",
    ),
    "rate_limits": ("test_rate_limits", "edge/test_budget"),
}
_CORE_FILES: Final = (
    "base.cpp",
    "base.h",
    "battery.h",
    "crc16.h",
    "decoder.cpp",
    "decoder.h",
    "frame.cpp",
    "frame.h",
    "power.h",
    "ramp.cpp",
    "ramp.h",
    "robot.cpp",
    "robot.h",
    "servo.cpp",
    "servo.h",
)


@dataclass(frozen=True, slots=True)
class Target:
    """A source, and the tests that must catch its faults."""

    file: str
    tests: tuple[str, ...]

    @property
    def is_cpp(self) -> bool:
        return not self.file.endswith(".py")

    @property
    def module(self) -> str:
        """The module's name in Python."""
        return self.file.removeprefix("server/").removesuffix(".py").replace("/", ".")

    @property
    def examples(self) -> tuple[str, ...]:
        """The quick ones of its tests."""
        return tuple(test for test in self.tests if not any(part in test for part in _LONG))

    @property
    def test_folders(self) -> tuple[str, ...]:
        return tuple(sorted({test.rpartition("/")[0] for test in self.tests}))


def _in(folder: str, tests: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"tests/{folder}/{test}.py" for test in tests)


_CORE_TESTS: Final = (
    "tests/firmware/test_core.py",
    "tests/firmware/test_core_edges.py",
    "tests/firmware/test_base.py",
    "tests/firmware/test_body.py",
    # Its other tests have faults of their own.
    "tests/firmware/test_line_black_channel.py::test_no_wrong_execution",
)

TARGETS: Final = (
    *(Target(f"server/wax/control/{k}.py", _in("control", v)) for k, v in _CONTROL.items()),
    *(Target(f"server/wax/robot/{k}.py", _in("robot", v)) for k, v in _ROBOT.items()),
    *(Target(f"server/wax/{k}.py", tuple(f"tests/{t}.py" for t in v)) for k, v in _OTHERS.items()),
    *(Target(f"{CORE}/{file}", _CORE_TESTS) for file in _CORE_FILES),
)
