"""The driver that the server holds: a driver process, and its senses in a media process."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from wax.robot.process.driver import ProcessDriver

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.config.controls import ControlSettings
    from wax.config.local import LocalSettings
    from wax.config.log import LogSettings
    from wax.config.robot import RobotSettings
    from wax.driver.interface import RobotState
    from wax.robot.known import Known
    from wax.robot.media.process import MediaProcess


class SensingDriver(ProcessDriver):
    """A `ProcessDriver` with exactly the senses (camera, microphone, …) that `known` names."""

    def __init__(
        self,
        settings: RobotSettings,
        clock: Clock,
        *,
        known: Known,
        media: MediaProcess,
        log: LogSettings | None = None,
        local: LocalSettings | None = None,
        claim: str = "",
        controls: Sequence[ControlSettings] = (),
    ) -> None:
        super().__init__(
            settings,
            clock,
            kind=known.kind,
            limits=known.limits,
            log=log,
            local=local,
            claim=claim,
            controls=controls,
        )
        self._media = media
        self.is_known = not known.is_guess
        # `isinstance` with `HasCamera` and the like treats a method set to None as missing.
        has = known.senses
        self.camera = media.camera if "camera" in has else None
        self.lone_camera = media.lone_camera
        self.external_view = media.external_view if "external_view" in has else None
        self.microphone = media.microphone if "microphone" in has else None
        self.speaker = media.speaker if "speaker" in has else None
        if known.own_view is not None:
            self.own_view = known.own_view

    def close(self) -> None:
        self._media.close(0.0)
        super().close()
        self._media.close()

    def abandon(self) -> None:
        self._media.close(0.0)
        super().abandon()

    def state(self) -> RobotState:
        state, pid = super().state(), self._media.pid
        extra = {"media_restarts": float(self._media.restarts)}
        if pid is not None:
            extra["media_pid"] = pid
        return replace(state, extra=state.extra | extra) if pid or self._media.restarts else state
