"""What the tape records of the room, and what it must not record."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import pytest
import structlog
from tests.heard_events import Heard
from tests.session.served_viewer import served_viewer
from tests.turned_clock import TurnedClock

from wax.config.recording import RecordingSettings
from wax.control.command import Command
from wax.control.gate import Setpoint
from wax.control.reasons import NOBODY_DRIVES, NOT_HELD, Hold, Limit, Refusal, stopped_by
from wax.control.stop_latch import LatchedStop
from wax.control.turns import TurnEnded, TurnRenewed, TurnStarted, Why
from wax.driver.interface import STANDSTILL, Pose, RobotState, Twist
from wax.errors import ForbiddenError
from wax.protocol import messages
from wax.sentence import Sentence, says
from wax.session.driven_turns import DISOWN_S
from wax.session.tape_keeper import KEPT_S, TapeKeeper

if TYPE_CHECKING:
    from collections.abc import Hashable

    from wax.control.loop import ControlLoop
    from wax.protocol.tape_events import TapeEvent
    from wax.session.viewer import Viewer
    from wax.tape.recorder import Recorder


class Writing:
    """A recorder that writes into a list."""

    def __init__(self) -> None:
        self.problem: Sentence | None = None
        self.events: list[tuple[TapeEvent, float]] = []
        self.lasting: dict[Hashable, TapeEvent] = {}
        self.kept: list[tuple[float, str]] = []
        self.disowned: list[tuple[float, float]] = []

    def event(self, event: TapeEvent, at_s: float, lasts_as: Hashable = None) -> None:
        self.events.append((event, at_s))
        if lasts_as is not None:
            self.lasting[lasts_as] = event

    def forget(self, lasts_as: Hashable) -> None:
        self.lasting.pop(lasts_as, None)

    def keep(self, since_s: float, by: str) -> None:
        self.kept.append((since_s, by))

    def disown(self, begin_s: float, end_s: float) -> None:
        self.disowned.append((begin_s, end_s))

    def of(self, kind: str) -> list[dict[str, Any]]:
        """Return the events of a kind."""
        return [event.model_dump() for event, _ in self.events if event.type == kind]


class Rig:
    """A keeper over viewers, a robot and a latch that the test sets."""

    def __init__(self, **settings: object) -> None:
        self.clock = TurnedClock(100.0)
        self.writing = Writing()
        self.heard = Heard(self.clock)
        self.viewers: list[Viewer] = []
        self.robot_state = RobotState(connected=True)
        self.latched: LatchedStop | None = None
        self.operated: dict[str, float] = {}
        self.keeper = TapeKeeper(
            cast("Recorder", self.writing),
            settings=RecordingSettings.model_validate(settings),
            clock=self.clock,
            viewers=self.viewers,
            control=cast("ControlLoop", self),
            has_sound=True,
            has_cameras=False,
            event_maker=self.heard.event_maker,
        )

    def steer(self, wanted: Setpoint, sent: Twist = STANDSTILL) -> None:
        self.keeper.steered(wanted, sent, 3, self.clock.time_s)
        self.clock.time_s += 0.02


@pytest.fixture
def rig() -> Rig:
    return Rig()


def command(sent_s: float, **more: Any) -> Command:
    known: dict[str, Any] = {
        "seq": 5,
        "turn": 3,
        "sent_s": sent_s,
        "linear": 0.5,
        "angular": 0.0,
        "held": True,
        "speed": "fast",
        "seen_s": sent_s - 0.1,
    }
    return Command(**known | more)


def test_a_command_is_written_with_its_age_and_its_fate(rig: Rig) -> None:
    """Times are ages, so that a reader needs no second clock."""
    rig.keeper.command_handled(7, command(99.95), None, 100.0)
    rig.keeper.command_handled(8, command(99.0, seen_s=None), Refusal.NOT_YOUR_TURN, 100.0)
    counted, refused = rig.writing.of("commanded")
    assert (counted["viewer"], counted["age_ms"], counted["seen_age_ms"]) == (7, 50.0, 150.0)
    assert counted["refused"] is None
    assert (refused["refused"], refused["seen_age_ms"]) == ("not_your_turn", None)


def test_sideways_is_written_where_there_is_any(rig: Rig) -> None:
    """A tape without sideways is as it always was, and reads as one; with it, nothing is lost."""
    for lateral in (0.0, -0.25):
        rig.keeper.command_handled(7, command(99.95, lateral=lateral), None, 100.0)
        rig.steer(Setpoint(Twist(0.5, 0.0, 2 * lateral)), Twist(0.2, 0.0, lateral))
    straight, aside = rig.writing.of("commanded")
    assert ("lateral" in straight, aside["lateral"]) == (False, -0.25)
    straight, aside = rig.writing.of("steered")
    assert not {"lateral_mps", "wanted_lateral_mps"} & set(straight)
    assert (aside["lateral_mps"], aside["wanted_lateral_mps"]) == (-0.25, -0.5)
    for event, _ in rig.writing.events:
        assert type(event).model_validate_json(event.model_dump_json()) == event


def test_a_set_point_is_written_when_it_changes(rig: Rig) -> None:
    """Fifty equal ones in a second are written once, and once more after a second."""
    driven = Setpoint(Twist(0.5, 0.0), limit=Limit.LONG_DELAY.value)
    for _ in range(25):
        rig.steer(driven, Twist(0.2, 0.0))
    rig.steer(Setpoint(reason=NOT_HELD))
    for _ in range(60):
        rig.steer(Setpoint(reason=NOT_HELD))
    first, second, again = rig.writing.of("steered")
    assert (first["linear_mps"], first["wanted_linear_mps"]) == (0.2, 0.5)
    assert (first["limit"], first["reason"]) == ("long_delay", None)
    assert second == again
    assert second["reason"] == "not_held"


@pytest.mark.parametrize(
    ("sentence", "told"),
    [
        (NOBODY_DRIVES, "nobody_drives"),
        (Refusal.TOO_OLD.value, "too_old"),
        (Hold.TURN_STARTED.value, "turn_started"),
        (says("The left wheel is off."), "robot"),
    ],
)
def test_reasons_have_short_names(rig: Rig, sentence: Sentence, told: str) -> None:
    """Sentences may be changed or translated; a tape is read years later."""
    rig.steer(Setpoint(reason=sentence))
    assert rig.writing.of("steered")[0]["reason"] == told


@pytest.mark.parametrize(
    ("has_sound", "has_cameras", "what"),
    [
        (True, False, "Picture, sound and driving are recorded"),
        (False, False, "Picture and driving are recorded"),
        (True, True, "The pictures of all cameras, sound and driving are recorded"),
        (False, True, "The pictures of all cameras and driving are recorded"),
    ],
)
def test_everybody_is_told_what_is_recorded(
    *, has_sound: bool, has_cameras: bool, what: str
) -> None:
    """Nobody is recorded by a camera without being told."""
    keeper = TapeKeeper(
        cast("Recorder", Writing()),
        settings=RecordingSettings(),
        clock=TurnedClock(),
        viewers=[],
        control=cast("ControlLoop", SimpleNamespace(latched=None)),
        has_sound=has_sound,
        has_cameras=has_cameras,
        event_maker=Heard(TurnedClock()).event_maker,
    )
    assert str(keeper.status().why).startswith(what)


def test_no_name_is_on_the_tape_unless_configured(rig: Rig) -> None:
    """Not even in the sentence of a Stop; and no address is ever written."""
    rig.viewers.append(served_viewer(2, "Ada"))
    rig.latched = LatchedStop(1, says("Ada"), 2)
    rig.steer(Setpoint(reason=stopped_by(says("Ada"))))
    rig.keeper.poll()
    text = "".join(event.model_dump_json() for event, _ in rig.writing.events)
    assert "Ada" not in text
    assert "192.0.2" not in text
    assert rig.writing.of("steered")[0]["reason"] == "pressed"


def test_names_that_are_configured_are_written_once() -> None:
    """A new name is written again; each is repeated in later parts."""
    rig = Rig(names=True)
    rig.viewers.append(served_viewer(2, "Ada"))
    for name in ("Ada", "Ada", "Countess"):
        rig.viewers[0].name = name
        rig.keeper.poll()
    assert [one["name"] for one in rig.writing.of("named")] == ["Ada", "Countess"]
    assert rig.writing.lasting["named", 2].model_dump()["name"] == "Countess"
    assert "with names" in str(rig.keeper.status().why)


def test_viewers_who_have_left_are_named_no_more() -> None:
    """Otherwise each part would begin with the names of everybody who ever came."""
    rig = Rig(names=True)
    rig.viewers += [served_viewer(2, "Ada"), served_viewer(3, "Eve")]
    rig.keeper.poll()
    del rig.viewers[0]
    rig.keeper.poll()
    assert list(rig.writing.lasting) == [("named", 3)]


def test_a_value_that_is_no_number_is_unknown(rig: Rig) -> None:
    """A robot may report NaN, with which nobody could read the tape."""
    nan = float("nan")
    rig.robot_state = RobotState(
        connected=True, pose=Pose(nan, 1.0, float("inf")), battery_v=nan, battery_fraction=nan
    )
    rig.steer(Setpoint())
    (reported,) = rig.writing.of("reported")
    assert (reported["x_m"], reported["y_m"], reported["heading_rad"]) == (None, 1.0, None)
    assert (reported["battery_v"], reported["battery_fraction"]) == (None, None)


def test_stops_are_written_when_pressed_and_released(rig: Rig) -> None:
    """Each is written even if one follows another at once."""
    for stop in (
        None,
        LatchedStop(1, says("Ada"), 2),
        LatchedStop(2, says("the host"), by_host=True),
        None,
    ):
        rig.latched = stop
        rig.steer(Setpoint())
    stops = [(one["number"], one["pressed"]) for one in rig.writing.of("stopped")]
    assert stops == [(1, True), (1, False), (2, True), (2, False)]


def test_turns_are_written(rig: Rig) -> None:
    """The tape has who drives, and why it ended; a renewed turn is not written."""
    rig.keeper.turn_events((TurnStarted(3, 7, 160.0), TurnRenewed(3, 7, 220.0)))
    rig.keeper.turn_events((TurnEnded(3, 7, Why.EXPIRED),))
    assert [(one["operator"], one["why"]) for one in rig.writing.of("turned")] == [
        (7, None),
        (None, "expired"),
    ]


def test_a_fault_keeps_the_last_two_minutes(rig: Rig) -> None:
    """A stop that nobody wanted is a fault; a pressed Stop or a released button is none."""
    rig.keeper.drive_status(7, True, None, 1.0)
    rig.keeper.drive_status(7, False, NOT_HELD, 1.0)
    assert rig.writing.kept == []
    rig.keeper.drive_status(7, True, None, 1.0)
    rig.latched = LatchedStop(1, says("Ada"), 2)
    rig.keeper.drive_status(7, False, stopped_by(says("Ada")), 1.0)
    assert rig.writing.kept == []
    rig.latched = None
    rig.keeper.drive_status(7, True, None, 1.0)
    rig.keeper.drive_status(7, True, Refusal.TOO_OLD.value, 1.0)
    assert rig.writing.kept == [(100.0 - KEPT_S, "fault")]
    assert rig.writing.of("faulted") == [{"type": "faulted", "operator": 7, "why": "too_old"}]


def test_keeping_often_reads_the_folder_rarely(rig: Rig) -> None:
    """However often somebody presses, the folder is read once in five seconds."""
    for _ in range(20):
        assert rig.keeper.keep("operator") == Sentence("tape.kept")
    assert rig.keeper.keep("host")
    assert [by for _, by in rig.writing.kept] == ["operator", "host"]
    assert [one["by"] for one in rig.heard.take()] == ["operator", "host"]


def test_everybody_is_told_whether_it_runs(rig: Rig) -> None:
    """They read what is recorded and for how long, or why it is not."""
    told = rig.keeper.status()
    assert told.running
    assert "without names" in str(told.why)
    assert "7 days" in str(told.why)
    rig.writing.problem = says("the disk is full")
    told = rig.keeper.status()
    assert (told.running, str(told.why)) == (False, "Nothing is recorded: the disk is full.")
    assert "Nothing is recorded" in str(rig.keeper.keep("host"))


def test_a_purpose_is_told_to_everybody() -> None:
    """They read what the recording is for before they drive; their pages offer to disown a turn."""
    told = Rig(purpose="A robot learns from it.").keeper.status()
    assert str(told.why).endswith("The recording also serves this purpose: A robot learns from it.")
    assert told.model_dump(exclude={"why"}) == {"running": True, "can_disown": True}


def drives(rig: Rig, turn: int, *, until: float | None = None) -> None:
    """Viewer 7 drives this turn, until a time if it ends."""
    rig.keeper.turn_events((TurnStarted(turn, 7, 160.0),))
    if until is not None:
        rig.clock.time_s = until
        rig.keeper.turn_events((TurnEnded(turn, 7, Why.LEFT),))


def test_a_turn_is_disowned_by_its_operator() -> None:
    """Once, from its beginning to its end."""
    rig = Rig(purpose="A robot learns from it.")
    rig.clock.time_s = 110.0
    drives(rig, 3, until=150.0)
    rig.clock.time_s = 150.0 + DISOWN_S
    assert rig.keeper.disown(7, 3) == Sentence("tape.disowned")
    assert rig.writing.disowned == [(110.0, 150.0)]
    with pytest.raises(ForbiddenError):
        rig.keeper.disown(7, 3)


@pytest.mark.parametrize(
    ("viewer", "turn", "at_s", "purpose"),
    [
        (8, 3, 151.0, "Learning."),
        (7, 2, 151.0, "Learning."),
        (7, 3, 149.0, "Learning."),
        (7, 3, 150.1 + DISOWN_S, "Learning."),
        (7, 3, 151.0, ""),
    ],
)
def test_nobody_else_disowns_a_turn(viewer: int, turn: int, at_s: float, purpose: str) -> None:
    """Neither another viewer, nor for another turn, one that lasts or is long over, nor in vain."""
    rig = Rig(purpose=purpose)
    drives(rig, 3, until=150.0 if at_s > 150.0 else None)
    rig.clock.time_s = at_s
    with pytest.raises(ForbiddenError):
        rig.keeper.disown(viewer, turn)
    assert rig.writing.disowned == []


def test_an_operator_says_what_they_do() -> None:
    """In one clean line, for their own turn; each part of the tape has it until the turn ends."""
    rig = Rig(ask_task=True)
    assert rig.keeper.status().asks_task
    drives(rig, 3)
    for viewer, turn, text in (
        (7, 3, " to the\n red post "),
        (7, 3, "to the red post"),
        (8, 3, "nothing"),
        (7, 2, "nothing"),
        (7, 3, "x" * 300),
    ):
        rig.keeper.set_task(viewer, messages.SetTask(type="task", turn=turn, text=text))
    told = [(one["turn"], one["text"]) for one in rig.writing.of("tasked")]
    assert told == [(3, "to the red post"), (3, "x" * messages.MAX_TASK_CHARS)]
    assert "tasked" in rig.writing.lasting
    drives(rig, 3, until=150.0)
    rig.keeper.set_task(7, messages.SetTask(type="task", turn=3, text="late"))
    assert len(rig.writing.of("tasked")) == 2
    assert "tasked" not in rig.writing.lasting


def test_a_task_that_nobody_asks_for_is_not_written(rig: Rig) -> None:
    """A strange page puts no text on the tape."""
    drives(rig, 3)
    rig.keeper.set_task(7, messages.SetTask(type="task", turn=3, text="anything"))
    assert rig.writing.of("tasked") == []


def test_how_viewers_are_served_is_written(rig: Rig) -> None:
    """The tape has the ages that their pages reported, and what was sent to them and why."""
    rig.viewers.append(served_viewer(2, "Ada"))
    rig.keeper.turn_events((TurnStarted(3, 2, 160.0),))
    rig.keeper.poll()
    (watched,) = rig.writing.of("watched")
    assert (watched["picture_ms"], watched["sound_ms"], watched["round_trip_ms"]) == (90, 120, 40)
    assert (watched["drives"], watched["rendition"], watched["why"]) == (
        True,
        "640x480",
        "All is sent.",
    )


def test_where_the_robot_is_is_written_ten_times_a_second(rig: Rig) -> None:
    """The pose changes in each tick of the control loop, more often than anybody needs."""
    for number in range(50):
        rig.robot_state = RobotState(connected=True, pose=Pose(number / 100, 0.0, 0.0))
        rig.steer(Setpoint())
    assert 8 <= len(rig.writing.of("reported")) <= 11


def test_axes_controls_and_gauges_are_written_where_there_are_any(rig: Rig) -> None:
    """An axis keeps its position; a control is written at once when it changes; busy gauges are
    written ten times a second, as a pose is.
    """
    rig.steer(Setpoint())
    assert not {"axes", "controls"} & set(rig.writing.of("steered")[0])
    for rig.operated in ({"horn": 1.0}, {}):
        rig.steer(Setpoint())
    operated = [one.get("controls") for one in rig.writing.of("steered")]
    assert operated == [None, {"horn": 1.0}, None]
    for number in range(50):
        gauges = {"motor_c": 20 + number / 100, "odd": math.nan}
        rig.robot_state = RobotState(connected=True, gauges=gauges)
        rig.steer(Setpoint(axes={"pan": 0.5} if number == 0 else {}))
    assert rig.writing.of("steered")[-1]["axes"] == {"pan": 0.5}
    reports = rig.writing.of("reported")
    assert "gauges" not in reports[0]
    assert reports[1]["gauges"].keys() == {"motor_c"}
    assert len(reports) <= 12


def test_an_error_stays_here(rig: Rig) -> None:
    """The control loop never sees the error, and the log has it once."""
    rig.keeper._control = cast("ControlLoop", None)  # a bug
    with structlog.testing.capture_logs() as logs:
        for _ in range(3):
            rig.steer(Setpoint())
    assert [one["event"] for one in logs] == ["the tape is incomplete"]
