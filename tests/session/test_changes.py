"""What of two looks is an event."""

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


class Looks:
    """Looks once a second at what the test sets."""

    def __init__(self) -> None:
        self.changes = Changes()
        self.now_s = 0.0
        self.look(1)

    def look(self, seconds: float, **seen: Any) -> list[tuple[float, str]]:
        """Return what was told, and after how many seconds."""
        told: list[tuple[float, str]] = []
        look = StateSeen(**({"is_open": True, "waiting": 0} | seen))
        for second in range(int(seconds)):
            told += [(second, event.type) for event in self.changes.look(look, self.now_s)]
            self.now_s += 1
        return told


def test_the_first_look_says_whether_it_is_open() -> None:
    """Whoever starts to listen then knows; later ones say when that changes."""
    assert [one.type for one in Changes().look(StateSeen(is_open=False, waiting=0), 0.0)] == [
        "door.closed"
    ]
    looks = Looks()
    assert looks.look(3) == []
    assert looks.look(3, is_open=False) == [(0, "door.closed")]
    assert looks.look(3) == [(0, "door.opened")]


def test_the_queue_is_told_when_it_begins_and_ends() -> None:
    """How many wait is not."""
    looks = Looks()
    assert looks.look(2, waiting=1) == [(0, "queue.waiting")]
    assert looks.look(2, waiting=5) == []
    assert looks.look(2) == [(0, "queue.empty")]


def test_a_fault_is_told_after_a_while_and_so_is_its_end() -> None:
    """What lasts three seconds, and then what is well for ten."""
    looks = Looks()
    assert looks.look(20, faults=GONE) == [(BEGAN_S, "fault.began")]
    assert looks.look(20) == [(MENDED_S - 1, "fault.mended")]


def test_a_moment_is_no_fault() -> None:
    """A source that is opened once more is not worth a message."""
    looks = Looks()
    assert looks.look(2, faults=GONE) == []
    assert looks.look(30) == []


def test_what_comes_and_goes_is_one_fault() -> None:
    """A loose plug is told once, also where it never fails for three seconds on end."""
    looks = Looks()
    told: list[tuple[float, str]] = []
    for _ in range(50):
        told += looks.look(2, faults=GONE) + looks.look(2)
    assert [kind for _, kind in told] == ["fault.began"]
    assert [kind for _, kind in looks.look(20)] == ["fault.mended"]


def test_each_fault_is_told_by_itself() -> None:
    """With its part, its name where there are several, and the code of why."""
    changes = Changes()
    seen = StateSeen(
        is_open=True,
        waiting=0,
        faults={("camera", "Door"): "camera.gone", ("gauge", "motor_c"): "stop", ("room", "2"): ""},
    )
    list(changes.look(seen, 0.0))
    told = [
        one.model_dump(exclude={"version", "timestamp", "type"}) for one in changes.look(seen, 5.0)
    ]
    assert told == [
        {"part": "camera", "which": "Door", "why": "camera.gone"},
        {"part": "gauge", "which": "motor_c", "why": "stop"},
        {"room": 2},
    ]


def test_a_room_elsewhere_is_lost_and_back() -> None:
    """By events of its own."""
    looks = Looks()
    assert looks.look(9, faults={("room", "1"): "lost"}) == [(BEGAN_S, "cluster.lost")]
    assert [kind for _, kind in looks.look(20)] == ["cluster.back"]


def test_a_weak_battery_is_told_once() -> None:
    """Below 15 %, until it is above 20 %, whatever it does between."""
    looks = Looks()
    assert looks.look(9, battery_fraction=0.16) == []
    assert looks.look(9, battery_fraction=0.14) == [(BEGAN_S, "fault.began")]
    assert looks.look(60, battery_fraction=0.19) == []
    assert [kind for _, kind in looks.look(20, battery_fraction=0.3)] == ["fault.mended"]
    assert looks.look(9, battery_fraction=float("nan")) == []


def test_a_robot_that_is_away_mends_nothing() -> None:
    """It tells no battery and no gauge, which says nothing of them."""
    looks = Looks()
    hot: dict[Fault, str] = {("gauge", "motor_c"): "warn"}
    looks.look(9, faults=hot)
    away = looks.look(60, faults={("robot", None): "robot.not_connected"})
    assert [kind for _, kind in away] == ["fault.began"]
    assert looks.look(9, faults=hot) == []


def test_what_fails_is_told_by_its_code() -> None:
    """Never by its words, which have ports and addresses; a name before it is left out."""
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
    """A gauge tells how far it is beyond; a robot without a problem to tell is not connected."""
    gauge = GaugeSettings(name="motor_c", warn_above=60.0, stop_above=85.0)
    hot = RobotState(connected=True, gauges={"motor_c": 90.0})
    assert faults({}, hot, [gauge], []) == {("gauge", "motor_c"): "stop"}
    assert faults({}, RobotState(connected=False), [gauge], []) == {
        ("robot", None): "robot.not_connected"
    }


def test_a_door_that_does_not_lead_here_is_told() -> None:
    """With the code of its sentence, and again when people elsewhere reach the page."""
    found = faults({}, RobotState(connected=True), [], [], Sentence("tunnel.closed", {"host": "h"}))
    assert found == {("tunnel", None): "tunnel.closed"}
    looks = Looks()
    assert looks.look(20, faults=found) == [(BEGAN_S, "tunnel.lost")]
    assert looks.look(20) == [(MENDED_S - 1, "tunnel.back")]
