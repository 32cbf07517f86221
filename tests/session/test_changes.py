"""Which changes between two polls are events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wax.config.controls import GaugeSettings
from wax.driver.interface import RobotState
from wax.sentence import Sentence, says
from wax.session.changes import BEGAN_S, MENDED_S, Changes, Fault, StateSeen, faults

if TYPE_CHECKING:
    from collections.abc import Mapping

CAMERA: Fault = ("camera", None)
GONE: Mapping[Fault, str] = {CAMERA: "camera.gone"}


class Poller:
    """Polls once a second what the test sets."""

    def __init__(self) -> None:
        self.changes = Changes()
        self.now_s = 0.0
        self.poll(1)

    def poll(self, seconds: float, **seen: Any) -> list[tuple[float, str]]:
        """Return the events, each after how many seconds it came."""
        told: list[tuple[float, str]] = []
        state = StateSeen(**({"is_open": True, "waiting": 0} | seen))
        for second in range(int(seconds)):
            told += [(second, event.type) for event in self.changes.compare(state, self.now_s)]
            self.now_s += 1
        return told


def test_the_first_poll_says_whether_it_is_open() -> None:
    """So a new listener knows; later polls report only a change."""
    assert [one.type for one in Changes().compare(StateSeen(is_open=False, waiting=0), 0.0)] == [
        "door.closed"
    ]
    poller = Poller()
    assert poller.poll(3) == []
    assert poller.poll(3, is_open=False) == [(0, "door.closed")]
    assert poller.poll(3) == [(0, "door.opened")]


def test_a_queue_is_reported_when_it_begins_and_ends() -> None:
    """How many people wait is not reported."""
    poller = Poller()
    assert poller.poll(2, waiting=1) == [(0, "queue.waiting")]
    assert poller.poll(2, waiting=5) == []
    assert poller.poll(2) == [(0, "queue.empty")]


def test_a_lasting_fault_and_its_end_are_reported() -> None:
    """A fault is reported after three seconds, its end after ten seconds without it."""
    poller = Poller()
    assert poller.poll(20, faults=GONE) == [(BEGAN_S, "fault.began")]
    assert poller.poll(20) == [(MENDED_S - 1, "fault.mended")]


def test_a_brief_failure_is_no_fault() -> None:
    """A source that is just reopened is not worth a message."""
    poller = Poller()
    assert poller.poll(2, faults=GONE) == []
    assert poller.poll(30) == []


def test_an_intermittent_fault_is_one_fault() -> None:
    """A loose plug is reported once, even if it never fails for three seconds in a row."""
    poller = Poller()
    told: list[tuple[float, str]] = []
    for _ in range(50):
        told += poller.poll(2, faults=GONE) + poller.poll(2)
    assert [kind for _, kind in told] == ["fault.began"]
    assert [kind for _, kind in poller.poll(20)] == ["fault.mended"]


def test_each_fault_is_reported_separately() -> None:
    """Each event has the part, its name where there are several, and the reason's code."""
    changes = Changes()
    seen = StateSeen(
        is_open=True,
        waiting=0,
        faults={("camera", "Door"): "camera.gone", ("gauge", "motor_c"): "stop", ("room", "2"): ""},
    )
    list(changes.compare(seen, 0.0))
    told = [
        one.model_dump(exclude={"version", "timestamp", "type"})
        for one in changes.compare(seen, 5.0)
    ]
    assert told == [
        {"part": "camera", "which": "Door", "why": "camera.gone"},
        {"part": "gauge", "which": "motor_c", "why": "stop"},
        {"room": 2},
    ]


def test_a_livekit_room_has_its_own_events() -> None:
    """A LiveKit room that is lost or back has events of its own."""
    poller = Poller()
    assert poller.poll(9, faults={("room", "1"): "lost"}) == [(BEGAN_S, "cluster.lost")]
    assert [kind for _, kind in poller.poll(20)] == ["cluster.back"]


def test_a_weak_battery_is_reported_once() -> None:
    """It is low below 15 %, until it is above 20 %, whatever happens in between."""
    poller = Poller()
    assert poller.poll(9, battery_fraction=0.16) == []
    assert poller.poll(9, battery_fraction=0.14) == [(BEGAN_S, "fault.began")]
    assert poller.poll(60, battery_fraction=0.19) == []
    assert [kind for _, kind in poller.poll(20, battery_fraction=0.3)] == ["fault.mended"]
    assert poller.poll(9, battery_fraction=float("nan")) == []


def test_a_disconnected_robot_mends_nothing() -> None:
    """It reports no battery and no gauge, which does not mean that they are well."""
    poller = Poller()
    hot: dict[Fault, str] = {("gauge", "motor_c"): "warn"}
    poller.poll(9, faults=hot)
    away = poller.poll(60, faults={("robot", None): "robot.not_connected"})
    assert [kind for _, kind in away] == ["fault.began"]
    assert poller.poll(9, faults=hot) == []


def test_a_fault_is_reported_by_its_code() -> None:
    """Its words, which have ports and addresses, are left out, and so is a name before them."""
    named = Sentence("camera.named", {"name": "Door", "problem": Sentence("camera.silent")})
    found = faults(
        {
            CAMERA: says("rtsp://192.0.2.1 is away"),
            ("microphone", None): None,
            ("camera", "D"): named,
        },
        RobotState(connected=True, problem=Sentence("robot.no_answer_on", {"port": "/dev/x"})),
        [GaugeSettings(name="motor_c", warn_above=60.0)],
        [2],
    )
    assert found == {
        CAMERA: "says",
        ("camera", "D"): "camera.silent",
        ("robot", None): "robot.no_answer_on",
        ("room", "2"): "lost",
    }


def test_gauges_and_a_robot_that_is_gone() -> None:
    """A gauge's reason is its level; a robot that is gone without a problem is not connected."""
    gauge = GaugeSettings(name="motor_c", warn_above=60.0, stop_above=85.0)
    hot = RobotState(connected=True, gauges={"motor_c": 90.0})
    assert faults({}, hot, [gauge], []) == {("gauge", "motor_c"): "stop"}
    assert faults({}, RobotState(connected=False), [gauge], []) == {
        ("robot", None): "robot.not_connected"
    }


def test_a_tunnel_that_does_not_lead_here_is_reported() -> None:
    """An event has its sentence's code; another follows when people elsewhere reach the page."""
    found = faults({}, RobotState(connected=True), [], [], Sentence("tunnel.closed", {"host": "h"}))
    assert found == {("tunnel", None): "tunnel.closed"}
    poller = Poller()
    assert poller.poll(20, faults=found) == [(BEGAN_S, "tunnel.lost")]
    assert poller.poll(20) == [(MENDED_S - 1, "tunnel.back")]
