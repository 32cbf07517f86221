"""Records on the tape what happens in the room; contains its own errors."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, Final, get_args

from wax.control.listener import Listener
from wax.control.turns import TurnEnded, TurnStarted
from wax.error_boundary import FirstErrorLogged
from wax.errors import ForbiddenError
from wax.protocol import messages, robot_report, tape_events
from wax.protocol.events import TapeKept
from wax.sentence import Sentence
from wax.session.driven_turns import DrivenTurns
from wax.session.names import clean_line
from wax.session.record_keeper import name_of, why_stopped
from wax.tape.retention import Keeper

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.access.permissions import Role
    from wax.clock import Clock
    from wax.config.recording import RecordingSettings
    from wax.control.command import Command
    from wax.control.gate import Setpoint
    from wax.control.loop import ControlLoop
    from wax.control.reasons import Refusal
    from wax.control.stop_latch import LatchedStop
    from wax.control.turns import TurnEvent
    from wax.driver.interface import RobotState, Twist
    from wax.session.event_maker import EventMaker
    from wax.session.record_keeper import DriveStatus
    from wax.session.viewer import Viewer
    from wax.tape.recorder import Recorder

KEPT_S: Final = 120.0
_POLL_S: Final = 1.0
_POSE_S: Final = 0.1
_REPEAT_S: Final = 1.0
"""Unchanged values are written this often, for a reader who has only a part of the tape."""
_KEEP_GAP_S: Final = 5.0
"""Each time the folder is read, and a bad link stops the robot again and again."""

_KEPT: Final = Sentence("tape.kept")
_DISOWNED: Final = Sentence("tape.disowned")
_NOT_YOURS: Final = Sentence("tape.not_yours")
_PRESSED: Final = "pressed"


class TapeKeeper(Listener):
    """Listens to the control loop, and polls the viewers once a second; no method raises."""

    def __init__(
        self,
        recorder: Recorder,
        *,
        settings: RecordingSettings,
        clock: Clock,
        viewers: Iterable[Viewer],
        control: ControlLoop,
        has_sound: bool,
        has_cameras: bool,
        event_maker: EventMaker,
    ) -> None:
        self._event_maker = event_maker
        self.recorder = recorder
        self._has_names = settings.names
        self._clock = clock
        self._viewers = viewers
        self._control = control
        self._runs = messages.Tape(
            running=True,
            why=_sentence(settings, has_sound=has_sound, has_cameras=has_cameras),
            can_disown=bool(settings.purpose),
            asks_task=settings.ask_task,
        )
        self._turns = DrivenTurns()
        self._operator: int | None = None
        self._stop: LatchedStop | None = None
        self._drive_status: DriveStatus | None = None
        self._newest: dict[str, tuple[tape_events.TapeEvent, float]] = {}
        self._names: dict[int, str] = {}
        self._axes: dict[str, float] = {}
        self._kept_s: dict[Keeper, float] = dict.fromkeys(get_args(Keeper), float("-inf"))
        self._contained = FirstErrorLogged("the tape is incomplete")
        """Wraps all work here: a failing tape must never stop the robot."""

    async def run(self) -> None:
        """Poll until cancelled."""
        while True:
            self.poll()
            await asyncio.sleep(_POLL_S)

    def status(self) -> messages.Tape:
        """Return the recording's status, as everybody sees it."""
        problem = self.recorder.problem
        if problem is None:
            return self._runs
        return messages.Tape(running=False, why=Sentence("tape.stands", {"why": problem}))

    def keep(self, role: Role) -> Sentence:
        """Keep the last two minutes for the host or the operator; return the answer for them."""
        self._keep("host" if role == "host" else "operator")
        status = self.status()
        return _KEPT if status.running else Sentence("tape.kept_but", {"but": status.why})

    def set_task(self, viewer: int, task: messages.SetTask) -> None:
        """Record what the operator does; of anybody else, or for another turn, it has no effect."""
        now_s = self._clock.now_s()
        text = clean_line(task.text, messages.MAX_TASK_CHARS)
        if self.status().asks_task and self._turns.set_task(viewer, task.turn, text):
            tasked = tape_events.Tasked(turn=task.turn, text=text)
            self.recorder.event(tasked, now_s, lasts_as="tasked")

    def disown(self, viewer: int, turn: int) -> Sentence:
        """Mark that a turn is not to be used, and return the answer for its operator.

        Raises `ForbiddenError` for anybody else, and two minutes after the turn.
        """
        now_s = self._clock.now_s()
        driven_s = self._turns.disown(viewer, turn, now_s) if self.status().can_disown else None
        if driven_s is None:
            raise ForbiddenError(_NOT_YOURS)
        self.recorder.disown(*driven_s)
        return _DISOWNED

    # --- what the control loop tells (Listener) ----------------------------------------------

    def command_handled(
        self, viewer: int, command: Command, refusal: Refusal | None, now_s: float
    ) -> None:
        with self._contained:
            seen_s = command.seen_s
            self.recorder.event(
                tape_events.Commanded(
                    viewer=viewer,
                    seq=command.seq,
                    turn=command.turn,
                    age_ms=_ms(now_s - command.sent_s),
                    seen_age_ms=None if seen_s is None else _ms(now_s - seen_s),
                    linear=command.linear,
                    angular=command.angular,
                    lateral=command.lateral,
                    held=command.held,
                    speed=command.speed,
                    axes=dict(command.axes),
                    refused=None if refusal is None else refusal.name.lower(),
                ),
                now_s,
            )

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None:
        with self._contained:
            self._follow_stop(self._control.latched, now_s)
            reason = None
            if wanted.reason is not None:
                reason = _PRESSED if self._stop is not None else name_of(wanted.reason)
            self._axes |= wanted.axes
            self._write_changed(
                tape_events.Steered(
                    turn=turn,
                    linear_mps=sent.linear_mps,
                    angular_rps=sent.angular_rps,
                    wanted_linear_mps=wanted.twist.linear_mps,
                    wanted_angular_rps=wanted.twist.angular_rps,
                    lateral_mps=sent.lateral_mps,
                    wanted_lateral_mps=wanted.twist.lateral_mps,
                    axes=dict(self._axes),
                    controls=dict(self._control.operated),
                    reason=reason,
                    limit=None if wanted.limit is None else name_of(wanted.limit),
                ),
                now_s,
            )
            self._write_robot(self._control.robot_state, now_s)

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        with self._contained:
            now_s = self._clock.now_s()
            for event in events:
                if isinstance(event, TurnStarted):
                    self._operator, why = event.operator, None
                    self._turns.began(event.number, event.operator, now_s)
                elif isinstance(event, TurnEnded):
                    self._operator, why = None, event.why.value
                    self._turns.ended(event.number, now_s)
                    self.recorder.forget("tasked")
                else:
                    continue
                turned = tape_events.Turned(number=event.number, operator=self._operator, why=why)
                self.recorder.event(turned, now_s, lasts_as="turned")

    def drive_status(
        self, number: int, moving: bool, reason: Sentence | None, _share: float
    ) -> None:
        """Keep the last two minutes if a fault has stopped the robot."""
        with self._contained:
            before, self._drive_status = self._drive_status, (number, moving, reason)
            why = why_stopped(before, self._drive_status)
            if why is None or self._control.latched is not None:
                return
            self.recorder.event(tape_events.Faulted(operator=number, why=why), self._clock.now_s())
            self._keep("fault")

    # --- the viewers -------------------------------------------------------------------------

    def poll(self) -> None:
        """Record how each viewer is served."""
        with self._contained:
            now_s = self._clock.now_s()
            for viewer in self._viewers:
                with viewer.boundary:
                    if viewer.is_ready:
                        self.recorder.event(self._watched(viewer), now_s)
                        self._write_name(viewer, now_s)
            self._forget_names()

    def _watched(self, viewer: Viewer) -> tape_events.Watched:
        one_way_s = viewer.link.one_way_s
        picture = None if viewer.report is None else viewer.report.picture
        sound = None if viewer.report is None else viewer.report.sound
        served = viewer.streams.status().served
        return tape_events.Watched(
            viewer=viewer.number,
            drives=viewer.number == self._operator,
            round_trip_ms=None if one_way_s is None else _ms(2 * one_way_s),
            picture_ms=None if picture is None else picture.age_ms,
            picture_held_ms=None if picture is None else picture.delay_ms,
            sound_ms=None if sound is None else sound.age_ms,
            sound_held_ms=None if sound is None else sound.delay_ms,
            rendition=None if served is None else served.rendition,
            picture_hz=None if served is None else served.picture_hz,
            sound_mu_ms=None if served is None else served.sound_mu_ms,
            link_bps=None if served is None else served.link_bps,
            queue_ms=None if served is None else served.queue_ms,
            why=None if served is None else str(served.reason),
        )

    def _write_name(self, viewer: Viewer, now_s: float) -> None:
        if self._has_names and self._names.get(viewer.number) != viewer.name:
            self._names[viewer.number] = viewer.name
            named = tape_events.Named(viewer=viewer.number, name=viewer.name)
            self.recorder.event(named, now_s, lasts_as=("named", viewer.number))

    def _forget_names(self) -> None:
        """Forget people who have left, so that no further part begins with their names."""
        for number in self._names.keys() - {viewer.number for viewer in self._viewers}:
            del self._names[number]
            self.recorder.forget(("named", number))

    # --- what follows from it ------------------------------------------------------------------

    def _follow_stop(self, stop: LatchedStop | None, now_s: float) -> None:
        before, self._stop = self._stop, stop
        number = None if stop is None else stop.number
        if before is not None and before.number != number:
            self._write_stop(before, now_s, pressed=False)
        if stop is not None and (before is None or before.number != number):
            self._write_stop(stop, now_s, pressed=True)

    def _write_stop(self, stop: LatchedStop, now_s: float, *, pressed: bool) -> None:
        stopped = tape_events.Stopped(
            number=stop.number, pressed=pressed, viewer=stop.viewer, by_host=stop.by_host
        )
        self.recorder.event(stopped, now_s, lasts_as="stopped")

    def _write_robot(self, state: RobotState, now_s: float) -> None:
        pose = state.pose
        reported = tape_events.Reported(
            connected=state.connected,
            problem=None if state.said is None else str(state.said),
            moving=state.moving,
            x_m=None if pose is None else _known(pose.x_m),
            y_m=None if pose is None else _known(pose.y_m),
            heading_rad=None if pose is None else _known(pose.heading_rad),
            gauges={
                name: value
                for name, value in state.gauges.items()
                if math.isfinite(value) and name not in robot_report.ROBOT_VALUES
            },
            **robot_report.report(state.told),
        )
        is_busy = pose is not None or reported.gauges
        self._write_changed(reported, now_s, gap_s=_POSE_S if is_busy else 0.0)

    def _write_changed(
        self, event: tape_events.Steered | tape_events.Reported, now_s: float, gap_s: float = 0.0
    ) -> None:
        """Record a change after `gap_s` at the earliest, an unchanged value every `_REPEAT_S`."""
        before, told_s = self._newest.get(event.type, (None, float("-inf")))
        if now_s - told_s >= (_REPEAT_S if event == before else gap_s):
            self._newest[event.type] = (event, now_s)
            self.recorder.event(event, now_s, lasts_as=event.type)

    def _keep(self, by: Keeper) -> None:
        now_s = self._clock.now_s()
        if now_s - self._kept_s[by] >= _KEEP_GAP_S:
            self._kept_s[by] = now_s
            self.recorder.keep(now_s - KEPT_S, by)
            self._event_maker.publish(TapeKept(by=by))


def _sentence(settings: RecordingSettings, *, has_sound: bool, has_cameras: bool) -> Sentence:
    """Say what is recorded, in which detail, and for how long."""
    if has_cameras:
        what = Sentence("tape.cameras_sound" if has_sound else "tape.cameras")
    else:
        what = Sentence("tape.picture_sound" if has_sound else "tape.picture")
    names = Sentence("tape.with_names" if settings.names else "tape.without_names")
    runs = Sentence("tape.runs", {"what": what, "names": names, "n": settings.keep_days})
    if not settings.purpose:
        return runs
    return Sentence("tape.runs_for", {"runs": runs, "purpose": settings.purpose})


def _known(value: float | None) -> float | None:
    """Return a robot's value, None for NaN and infinity: a tape has neither."""
    return value if value is not None and math.isfinite(value) else None


def _ms(duration_s: float) -> float:
    return round(duration_s * 1000, 1)
