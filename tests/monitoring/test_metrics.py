"""The metrics for Prometheus, the dashboard that shows them, and readiness."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import aiohttp
import pytest
from prometheus_client.parser import text_string_to_metric_families
from tests.turned_clock import TurnedClock

from wax.config.metrics import MetricSettings
from wax.control.driving_view import DrivingView
from wax.control.loop_timer import Lateness
from wax.errors import StartError
from wax.monitoring.listener import MetricsListener
from wax.monitoring.metrics import Metrics
from wax.monitoring.readiness import LATE, STOPPING, Readiness
from wax.records.records import Records
from wax.session.record_keeper import refused

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.control.loop import ControlLoop

DASHBOARD = Path(__file__).parents[2] / "config" / "deploy" / "grafana.json"


def line(role: str, **more: object) -> dict[str, object]:
    return {"id": 1, "name": "Ada", "role": role, **more}


def whole(picture_ms: float | None, skew_ms: float | None) -> dict[str, object]:
    return {
        "round_trip_ms": 40.0,
        "skew_ms": skew_ms,
        "report": {"picture": {"age_ms": picture_ms}, "sound": None},
        "streams": {"rendition": "640x480"},
    }


def status() -> dict[str, Any]:
    return {
        "version": "1.2",
        "viewers": [
            line("operator", **whole(80.0, -30.0)),
            line("observer", **whole(None, 10.0)),
            line("observer"),  # without measurements
            line("queued", **whole(240.0, None)),
        ],
        "turn": {"number": 7, "operator": 1, "seconds_left": 2.0},
        "stop": None,
        "robot": {"connected": True, "battery_fraction": 0.5},
        "streams": {
            "video": {
                "problem": None,
                "failures": 1,
                "captured_fps": 30.0,
                "encoded_fps": {"640x480": 29.9},
                "dropped": 4,
            },
            "audio": {"problem": "gone", "failures": 0, "captured_hz": 100.0, "dropped": 0},
        },
        "limits": {"left": ["1280x720"], "largest": "960x540", "observers_bps": 2e6},
        "cameras": [
            {"name": "Door", "problem": "gone", "failures": 2, "captured_fps": 14.9},
        ],
        "counters": {"requests refused": 3, "commands.accepted": 9, "control.latest_ms": 1.5},
        "tasks": 12,
        "steps": {"machine.memory.run": {"count": 3, "longest_ms": 9.5}},
        "tape": {
            "problem": None,
            "parts": 3,
            "parts_bytes": 8_000_000,
            "waiting": 2,
            "left_out": 5,
        },
        "hooks": [
            {
                "name": "1 (example.org)",
                "problem": None,
                "disabled": False,
                "waiting": 3,
                "refused": 2,
                "lost": 6,
            }
        ],
    }


@pytest.fixture
def lateness() -> Lateness:
    return Lateness()


def metrics(lateness: Lateness, told: Callable[[], dict[str, Any]] = status) -> Metrics:
    return Metrics(
        status=told,
        refused=refused,
        stops={"pressed": 2},
        lateness=lateness,
        records=Records(TurnedClock()),
    )


def samples(text: bytes) -> dict[tuple[str, ...], float]:
    """Return every sample by its name and its labels' values, in the order of the labels."""
    return {
        (one.name, *(value for _, value in sorted(one.labels.items()))): one.value
        for family in text_string_to_metric_families(text.decode())
        for one in family.samples
    }


def test_what_is_exported(lateness: Lateness) -> None:
    """Every figure of the status is exported under its name and labels."""
    for late_s in (0.0, 0.0004, 0.003, 0.5):
        lateness.add(late_s)
    found = samples(metrics(lateness).text())
    expected = {
        ("wax_info", "1.2"): 1,
        ("wax_viewers", "operator"): 1,
        ("wax_viewers", "observer"): 2,
        ("wax_queue_length",): 1,
        ("wax_rendition_viewers", "640x480"): 3,
        ("wax_sizes_left",): 1,
        ("wax_observers_limited",): 1,
        ("wax_picture_age_seconds", "median", "all"): 0.16,
        ("wax_picture_age_seconds", "worst", "all"): 0.24,
        ("wax_picture_age_seconds", "worst", "operator"): 0.08,
        ("wax_skew_seconds", "worst", "all"): -0.03,
        ("wax_round_trip_seconds", "median", "all"): 0.04,
        ("wax_turns_total",): 7,
        ("wax_stops_total", "pressed"): 2,
        ("wax_stop_latched",): 0,
        ("wax_robot_connected",): 1,
        ("wax_battery_ratio",): 0.5,
        ("wax_source_up", "video"): 1,
        ("wax_source_up", "audio"): 0,
        ("wax_dropped_total", "video"): 4,
        ("wax_refused_total", "requests refused"): 3,
        ("wax_events_total", "commands.accepted"): 9,
        ("wax_loop_lateness_seconds_bucket", "0.0005"): 2,
        ("wax_loop_lateness_seconds_bucket", "0.005"): 3,
        ("wax_loop_lateness_seconds_bucket", "0.2"): 3,
        ("wax_loop_lateness_seconds_bucket", "+Inf"): 4,
        ("wax_loop_lateness_seconds_count",): 4,
        ("wax_records_waiting",): 0,
        ("wax_tape_running",): 1,
        ("wax_tape_parts",): 3,
        ("wax_tape_bytes",): 8_000_000,
        ("wax_tape_waiting",): 2,
        ("wax_tape_left_out_total",): 5,
        ("wax_hook_waiting", "1 (example.org)"): 3,
        ("wax_hook_lost_total", "1 (example.org)"): 6,
        ("wax_hook_refused_total", "1 (example.org)"): 2,
        ("wax_hook_disabled", "1 (example.org)"): 0,
        ("wax_long_steps_total", "machine.memory.run"): 3,
        ("wax_longest_step_seconds", "machine.memory.run"): 0.0095,
    }
    assert {key: found.get(key) for key in expected} == expected
    assert ("wax_sound_age_seconds", "median", "all") not in found
    assert not [key for key in found if key[0] == "wax_events_total" and "latest" in key[1]]


def test_without_a_tape_there_is_no_figure_of_it(lateness: Lateness) -> None:
    """A server without a tape exports no metrics of one."""
    assert b"wax_tape" not in metrics(lateness, lambda: status() | {"tape": None}).text()


def test_a_tape_that_has_stopped_is_seen(lateness: Lateness) -> None:
    """A tape with a problem is exported as not running."""
    tape = status()["tape"] | {"problem": "the disk is full"}
    found = samples(metrics(lateness, lambda: status() | {"tape": tape}).text())
    assert found["wax_tape_running",] == 0


def test_nobody_is_named(lateness: Lateness) -> None:
    """No metric has a person's name."""
    assert b"Ada" not in metrics(lateness).text()


def test_the_dashboard_asks_for_what_there_is(lateness: Lateness) -> None:
    """Every metric on the dashboard is exported, and every metric of ours is on it."""
    lateness.add(0.001)
    text = DASHBOARD.read_text(encoding="utf-8")
    board = json.loads(text)
    asked = {
        name
        for panel in board["panels"]
        for target in panel["targets"]
        for name in re.findall(r"\b(?:wax|process)_\w+", target["expr"])
    }
    exported = {key[0] for key in samples(metrics(lateness).text())} | {"wax_sound_age_seconds"}
    assert asked <= exported
    assert {name for name in exported if name.startswith("wax_")} - {
        f"{name}_created" for name in exported
    } <= asked


async def test_they_are_served_on_a_port_of_their_own() -> None:
    """The port serves only metrics, in Prometheus's content type; a taken port is a sentence."""
    listener = MetricsListener(MetricSettings(host="127.0.0.1", port=0), lambda: b"wax_x 1\n")
    port = await listener.open()
    async with aiohttp.ClientSession() as session:
        async with session.get(f"http://127.0.0.1:{port}/metrics") as response:
            assert response.headers["Content-Type"].startswith("text/plain; version=")
            assert await response.read() == b"wax_x 1\n"
        async with session.get(f"http://127.0.0.1:{port}/") as response:
            assert response.status == 404
    second = MetricsListener(MetricSettings(host="127.0.0.1", port=port), bytes)
    with pytest.raises(StartError, match=rf"{port}.*\[metrics\] port"):
        await second.open()
    await second.close()
    await listener.close()


class Rig:
    """A server with a fake clock, robot and camera."""

    def __init__(self) -> None:
        self.clock = TurnedClock()
        self.state = SimpleNamespace(connected=True, problem=None)
        self.control = SimpleNamespace(stepped_s=self.clock.time_s, robot_state=self.state)
        self.video = SimpleNamespace(problem=None)
        self.is_stopping = False
        self.view = DrivingView()
        self.view.camera = self.video
        self.readiness = Readiness(
            clock=self.clock,
            control=cast("ControlLoop", self.control),
            view=self.view,
            is_stopping=lambda: self.is_stopping,
        )


def test_not_ready_by_pictures_of_unknown_age() -> None:
    """A server is not ready once its pictures' age has been unknown for a while."""
    rig = Rig()
    rig.view.captured(rig.clock.time_s, None)
    assert rig.readiness() == {}
    rig.control.stepped_s = rig.clock.time_s = rig.clock.time_s + 3.1
    assert "nobody knows how old it is" in rig.readiness()["camera"]


def test_ready_is_when_somebody_could_drive() -> None:
    """A server is ready with a robot, a camera and a running control loop; sound is optional."""
    rig = Rig()
    assert rig.readiness() == {}
    rig.video.problem = "unplugged"
    rig.state.problem = "no answer"
    rig.is_stopping = True
    rig.clock.time_s += 0.6
    assert rig.readiness() == {
        "server": STOPPING,
        "control": LATE,
        "robot": "no answer",
        "camera": "unplugged",
    }


def test_a_robot_that_does_not_say_why() -> None:
    """A disconnected robot without a problem of its own is still a reason."""
    rig = Rig()
    rig.state.connected = False
    assert list(rig.readiness()) == ["robot"]
