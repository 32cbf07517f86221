"""The messages to all pages about the robot, the queue and the streams."""

from __future__ import annotations

from functools import lru_cache
from operator import itemgetter
from typing import TYPE_CHECKING, Final

from wax import __version__
from wax.capture.undated import undated
from wax.control import reasons
from wax.control.gate import LAPSE_S
from wax.driver.interface import Aboard, KnowsItsView
from wax.protocol import messages, robot_report
from wax.protocol.host_switches import HostSettings
from wax.records.shortened import shortened
from wax.sentence import Sentence
from wax.session import equipment
from wax.session.diagnosis import for_guests
from wax.session.presence import LOST_S

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from wax.access.admission import Grant, Visitor
    from wax.driver.interface import RobotState
    from wax.session.parts import Parts
    from wax.session.stop_budget import PressingAddress
    from wax.session.viewer import Viewer

_MOST_TOLD: Final = 40
"""Waiting viewers listed in a message to the LiveKit rooms."""
_viewer_info: Final = lru_cache(maxsize=256)(messages.ViewerInfo)
"""Unchanged lines are the same object, so that comparing a crowd's lines is fast."""


class PageMessages:
    """Makes the messages for all pages and for new ones; changes no state."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._settings = parts.settings
        self._service = parts.pipelines.service
        # Read once, at the start: a plug-in driver may raise later.
        driver = parts.driver
        self._kind, self._limits = driver.kind, driver.limits
        self._own_view = driver.own_view if isinstance(driver, KnowsItsView) else None
        self._viewers = parts.viewers
        self._turns = parts.turns
        self._control = parts.control
        self._captures = parts.pipelines.captures
        self._cameras = parts.pipelines.cameras
        self._access = parts.access
        self._decisions = parts.decisions
        self._voices = parts.voices

    def hello(self, number: int, visitor: Visitor, grant: Grant) -> messages.Hello:
        """Return the greeting for the viewer with this number, 0 for one in a LiveKit room."""
        here = 0 if visitor.is_embed else number
        return messages.Hello(
            version=__version__,
            viewer=number,
            page=messages.PageInfo.model_validate(self._settings.page, from_attributes=True),
            robot=self._robot(),
            sizes=list(self._service.sizes),
            turn_s=self._settings.turns.turn_s,
            grace_s=self._settings.turns.grace_s,
            command_rate_hz=self._settings.drive.command_rate_hz,
            click_to_move=self._settings.drive.click_to_move,
            on_loss=self._on_loss(),
            is_host=visitor.is_host,
            has_microphone="audio" in self._captures,
            may_hear=grant.hear,
            may_queue=grant.queue,
            acknowledge=self._service.acknowledged,
            voice=self._voice_rules(here),
            cameras=self._camera_infos(here),
            controls=equipment.controls(self._settings.controls) if here else [],
            gauges=equipment.gauges(self._settings.gauges),
        )

    def room(self, now_s: float) -> messages.RoomState:
        """Return the state of the room, with the viewers who have connected."""
        state, stop = self._control.robot_state, self._control.latched
        return messages.RoomState(
            viewers=self._lines(now_s),
            turn=messages.TurnInfo(
                number=self._turns.number,
                operator=self._turns.operator,
                ends_server_ms=_ms(self._turns.ends_s),
                stands_left_ms=_whole_ms(self._turns.paused_left_s(now_s)),
                axes=dict(self._control.first_axes),
            ),
            call=self._call(),
            stop=None if stop is None else messages.StopInfo.model_validate(stop),
            host_settings=self._host_settings(now_s),
            robot=messages.RobotStatus(
                connected=state.connected,
                problem=state.said,
                **robot_report.report(state.told),
                gauges=equipment.gauge_values(self._settings.gauges, state),
                beyond=equipment.beyond(self._settings.gauges, state),
                ttl_ms=_ms(state.ttl_s),
            ),
            video=messages.ViewStatus(
                problem=self._problem("video", Sentence("camera.none")),
                undated=self._undated(now_s),
            ),
            audio=messages.SourceStatus(problem=self._problem("audio", None)),
            voice=None if self._voices is None else self._voices.info(),
            tape=None if self._parts.tape is None else self._parts.tape.status(),
            aboard=self._aboard(state),
            cameras=[messages.SourceStatus(problem=one.problem) for one in self._cameras],
            controls=dict(self._control.control_values),
            no_way_in=None if self._parts.tunnel.problem is None else Sentence("tunnel.nobody_new"),
        )

    def for_rooms(self, room: messages.RoomState, watching: int, now_s: float) -> messages.Told:
        """Return the message for the LiveKit rooms; `watching` counts all but the operator."""
        placed = ((one.place, one) for one in room.viewers if one.place is not None)
        first = [one for _, one in sorted(placed, key=itemgetter(0))[:_MOST_TOLD]]
        return messages.Told(
            server_ms=now_s * 1000,
            watching=watching,
            room=for_guests(room).model_copy(update={"viewers": first}),
        )

    def console(
        self, lines: list[messages.ConsoleViewer], pressers: Iterable[PressingAddress]
    ) -> messages.Console:
        """Return what only the host sees, with a line of each viewer."""
        parts, reused_at = self._parts, self._access.reused_at
        return messages.Console(
            viewers=lines,
            closed=not self._access.is_open,
            opens_wall_ms=self._access.opens_wall_ms,
            pressers=[
                messages.Presser(
                    id=one.number,
                    address=shortened(one.address),
                    by=one.by,
                    presses=one.presses,
                    muted=one.address in self._decisions.muted_addresses,
                )
                for one in pressers
            ],
            reused=None if reused_at is None else shortened(reused_at),
            problems=[
                *parts.kept.problems(),
                *self._service.limits.problems(),
                *parts.tunnel.problems(),
                *parts.hooks.problems(),
                *parts.house.problems(),
            ],
        )

    def console_line(self, viewer: Viewer) -> messages.ConsoleViewer:
        """Return what only the host sees of a viewer."""
        one_way_s = viewer.link.one_way_s
        picture = None if viewer.report is None else viewer.report.picture
        served = viewer.streams.status().served
        return messages.ConsoleViewer(
            id=viewer.number,
            address=shortened(viewer.visitor.address),
            invited=viewer.visitor.is_invited,
            muted=viewer.visitor.identity in self._decisions.muted,
            round_trip_ms=None if one_way_s is None else round(one_way_s * 2000),
            picture_ms=None if picture is None else picture.age_ms,
            rendition=None if served is None else served.rendition,
        )

    def _aboard(self, state: RobotState) -> messages.AboardInfo | None:
        """Return the status of the person aboard, None if the configuration has none."""
        local = self._settings.local
        if not local.is_on:
            return None
        aboard = state.aboard or Aboard("lost")
        return messages.AboardInfo(
            mode=aboard.mode,
            reason=reasons.ABOARD.get(aboard.mode),
            asked=aboard.asked,
            asks=aboard.asks,
            takes_part=local.stick == "shares",
        )

    def _host_settings(self, now_s: float) -> HostSettings:
        message, ends_s = self._decisions.message_at(now_s)
        return HostSettings(
            message=message,
            message_ends_server_ms=_ms(ends_s),
            **self._decisions.switches.told(),
        )

    def _call(self) -> messages.CallInfo | None:
        call = self._turns.call
        if call is None:
            return None
        return messages.CallInfo(viewer=call.viewer, until_server_ms=call.until_s * 1000)

    def _on_loss(self) -> messages.LossRules:
        drive, limits = self._settings.drive, self._limits
        return messages.LossRules(
            max_age_ms=drive.max_age_ms,
            max_command_age_ms=drive.max_command_age_ms,
            slow_picture_age_ms=drive.slow_picture_age_ms,
            stop_picture_age_ms=drive.stop_picture_age_ms,
            resume_within_ms=LAPSE_S * 1000,
            lost_after_ms=LOST_S * 1000,
            max_stop_distance_m=drive.max_stop_distance_m,
            silence_ms=_ms(limits.silence_s),
            robot_ttl_ms=_ms(limits.ttl_s),
            soft_braking=self._settings.robot.soft_braking,
            stop_by=self._settings.stop.by,
        )

    def _lines(self, now_s: float) -> list[messages.ViewerInfo]:
        places = self._turns.places(now_s)
        lines = []
        for viewer in self._viewers:
            with viewer.boundary:
                if viewer.was_ready:
                    lines.append(self._line(viewer, places))
        return lines

    def line(self, viewer: Viewer, now_s: float) -> messages.ViewerInfo:
        """Return what everybody sees of a viewer."""
        return self._line(viewer, self._turns.places(now_s))

    def _line(
        self, viewer: Viewer, places: Mapping[int, tuple[int, float | None]]
    ) -> messages.ViewerInfo:
        place, wait_s = places.get(viewer.number, (None, None))
        return _viewer_info(
            id=viewer.number,
            name=viewer.name,
            role="observer" if place is None else "operator" if place == 0 else "queued",
            place=place,
            wait_s=None if wait_s is None else round(wait_s),
            lost=self._turns.is_lost(viewer.number),
            host=viewer.visitor.is_host,
        )

    def _robot(self) -> messages.RobotInfo:
        robot, limits = self._settings.robot, self._limits
        return messages.RobotInfo(
            kind=self._kind,
            max_linear_mps=limits.linear_mps,
            max_angular_rps=limits.angular_rps,
            max_lateral_mps=limits.lateral_mps,
            slow_fraction=self._settings.drive.slow_fraction,
            axes=list(limits.axes),
            motion=messages.MotionInfo(
                acceleration_mps2=robot.max_linear_acceleration_mps2,
                acceleration_rps2=robot.max_angular_acceleration_rps2,
                braking_mps2=robot.braking_mps2,
            ),
            camera=self._camera_geometry(),
            camera_stereo=self._settings.video.camera_stereo,
            width_m=robot.width_m or (None if self._own_view is None else self._own_view.width_m),
        )

    def _camera_geometry(self) -> messages.CameraGeometry | None:
        """Return how the driving view sees the floor: as the host says, or the robot itself."""
        video = self._settings.video
        if video.camera_height_m:
            return messages.CameraGeometry(
                height_m=video.camera_height_m,
                tilt_deg=video.camera_tilt_deg,
                fov_deg=video.camera_fov_deg,
                axis_row=0.5,
            )
        own = self._own_view
        # The robot cannot know that the host turns the picture: no path is better than a wrong one.
        if video.source not in ("auto", "robot") or own is None or video.is_turned:
            return None
        return messages.CameraGeometry(
            height_m=own.height_m,
            tilt_deg=own.tilt_deg,
            fov_deg=own.fov_deg,
            axis_row=own.axis_row,
        )

    def _voice_rules(self, number: int) -> messages.VoiceRules | None:
        if self._voices is None or number == 0:  # LiveKit rooms and embeds cannot speak
            return None
        return messages.VoiceRules.model_validate(self._settings.voice, from_attributes=True)

    def _camera_infos(self, number: int) -> list[messages.CameraInfo]:
        if number == 0:  # LiveKit rooms and embeds have only the driving view
            return []
        return [messages.CameraInfo(name=one.name, axes=one.settings.axes) for one in self._cameras]

    def _undated(self, now_s: float) -> Sentence | None:
        """Return why nobody can drive by the driving view although it delivers pictures."""
        is_doubted = self._parts.pipelines.view.clock.is_doubted(now_s)
        return undated(self._settings.video.source) if is_doubted else None

    def _problem(self, stream: str, absent: Sentence | None) -> Sentence | None:
        capture = self._captures.get(stream)
        return absent if capture is None else capture.problem


def _whole_ms(duration_s: float | None) -> float | None:
    """Return whole milliseconds: a paused clock must not change by rounding."""
    return None if duration_s is None else round(duration_s * 1000)


def _ms(duration_s: float | None) -> float | None:
    return None if duration_s is None else duration_s * 1000
