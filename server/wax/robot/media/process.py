"""The server's end of the media process: provides the robot's senses and keeps it running."""

from __future__ import annotations

import contextlib
import os
import socket
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, Final

import structlog

from wax.config.log import LogSettings
from wax.robot.media.link import MediaProcessLink
from wax.robot.media.messages import MediaBegin, Outlet
from wax.robot.media.picture_memory import make_memory
from wax.robot.media.senses import RemoteCamera, RemoteMicrophone, RemoteSpeaker
from wax.robot.process.child_process import ChildProcess
from wax.robot.process.kept_process import KeptProcess, RestartPauses
from wax.robot.process.resource_limits import ResourceUse
from wax.sentence import Sentence

if TYPE_CHECKING:
    import threading

    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.video import VideoSettings
    from wax.robot.media.messages import Sense

_LOG = structlog.get_logger(__name__)

_MODULE: Final = "wax.robot.media"
_NO_PICTURE: Final = Sentence("camera.silent")
START_S: Final = 20.0
"""A plug-in's libraries may take long to load on a small machine."""
HUNG_S: Final = 3.0
"""The heartbeat timeout; heartbeats come twice a second unless a plug-in holds the interpreter."""
STUCK_S: Final = 6.0
"""A sense that is silent for this long causes a restart, unless other senses still work."""
_LOOK_S: Final = 0.5
PAUSES: Final = RestartPauses(first_s=0.5, last_s=10.0, steady_s=10.0)
END_S: Final = 1.0
"""How long a process may take to end."""


@dataclass(frozen=True)
class _Wanted:
    """One sense that the server uses; it outlives restarts of the process."""

    sense: Sense
    link: MediaProcessLink
    video: dict[str, Any] | None = None


class MediaProcess(KeptProcess):
    """Camera, microphone and speaker of one robot, in a process that is restarted when it ends.

    Make all senses before opening the first: that starts the process, and `close` ends it. A
    failure does not affect the robot's driver, which runs in another process.
    """

    def __init__(self, settings: RobotSettings, log: LogSettings | None = None) -> None:
        super().__init__("media process", time.monotonic, PAUSES)
        self._settings = settings
        self._log = log or LogSettings()
        self._wanted: list[_Wanted] = []
        self._resource_use = ResourceUse()
        self.restarts = 0

    @property
    def pid(self) -> int | None:
        """The PID of the current process, None if there is none."""
        child = self._child
        return None if child is None else child.pid

    def camera(self, settings: VideoSettings, _clock: Clock) -> RemoteCamera:
        """Make a source, as `HasCamera.camera` does."""
        return RemoteCamera(self._link("camera", _NO_PICTURE, settings), self._start)

    def lone_camera(self, settings: VideoSettings, _clock: Clock) -> RemoteCamera:
        """Make the same source in another process, which its `close` ends."""
        lone = MediaProcess(self._settings, self._log)
        return RemoteCamera(lone._link("camera", _NO_PICTURE, settings), lone._start, lone.close)

    def external_view(self, settings: VideoSettings, _clock: Clock) -> RemoteCamera:
        """Make a source, as `HasExternalView.external_view` does."""
        return RemoteCamera(self._link("external_view", _NO_PICTURE, settings), self._start)

    def microphone(self, _clock: Clock) -> RemoteMicrophone:
        """Make a source, as `HasMicrophone.microphone` does."""
        return RemoteMicrophone(
            self._link("microphone", Sentence("microphone.silent")), self._start
        )

    def speaker(self, _clock: Clock) -> RemoteSpeaker:
        """Make an output, as `HasSpeaker.speaker` does."""
        return RemoteSpeaker(self._link("speaker", Sentence("speaker.hangs")), self._start)

    def close(self, within_s: float = END_S) -> None:
        """Tell the process to end, and wait for that; safe to call twice.

        If it does not end in time it is killed: a process whose plug-in holds the interpreter would
        never read the end of the pipe, and would keep the camera.
        """
        self._end(within_s)
        if within_s > 0.0:
            self._kill()

    def _link(
        self, sense: Sense, silent: Sentence, video: VideoSettings | None = None
    ) -> MediaProcessLink:
        dumped = None if video is None else video.model_dump(mode="json", exclude_unset=True)
        wanted = _Wanted(sense, MediaProcessLink(silent), dumped)
        self._wanted.append(wanted)
        return wanted.link

    # --- the process's life, in a thread ----------------------------------------------------

    def _lost(self, problem: Sentence, *, is_over: bool) -> None:
        for wanted in self._wanted:
            wanted.link.detach(problem)
        self.restarts += not is_over

    def _dismiss(self, child: ChildProcess) -> None:
        child.hang_up()

    def _not_started(self, why: str) -> Sentence:
        return Sentence("media.not_started", {"why": why})

    def _ended(self, status: int) -> Sentence:
        if status < 0:
            return Sentence("media.killed", {"signal": -status})
        return Sentence("media.ended", {"status": status})

    def _watch(self, child: ChildProcess, closing: threading.Event) -> Sentence | None:
        """Wait for its end; return a sentence if it must be killed, None once it has ended."""
        deadline_s = time.monotonic() + START_S
        while (data := child.receive(_LOOK_S)) is not None:
            if closing.is_set():
                deadline_s = min(deadline_s, time.monotonic() + END_S)
            elif data:
                deadline_s = time.monotonic() + HUNG_S
            if time.monotonic() >= deadline_s:
                child.kill()
                return Sentence("media.hangs")
            if self._is_stuck():
                child.kill()
                return Sentence("media.hangs")
            if (excess := self._resource_use.excess(child.pid)) is not None:
                return Sentence("media.greedy", {"what": excess})
        return None

    def _is_stuck(self) -> bool:
        """Whether a sense has hung long enough to warrant a restart, and no other sense works."""
        now_s = time.monotonic()
        links = [wanted.link for wanted in self._wanted]
        hangs = any(now_s - (link.silent_since_s or now_s) > STUCK_S for link in links)
        return hangs and not any(now_s - link.answered_s < STUCK_S for link in links)

    def _spawn(self) -> ChildProcess:
        """Start a process with a connection to each sense; raises `OSError`."""
        with contextlib.ExitStack() as given:
            outlets = []
            for wanted in self._wanted:
                ours, theirs = socket.socketpair()
                given.callback(theirs.close)
                connection = Connection(ours.detach())
                memory = None
                if wanted.video is not None:
                    memory = make_memory()
                    given.callback(os.close, memory)
                wanted.link.attach(connection, memory)
                outlets.append(
                    Outlet(
                        sense=wanted.sense,
                        connection=theirs.fileno(),
                        memory=memory,
                        video=wanted.video,
                    )
                )
            begin = MediaBegin(robot=self._settings, log=self._log, outlets=outlets)
            descriptors = [
                number
                for one in outlets
                for number in (one.connection, one.memory)
                if number is not None
            ]
            line = begin.model_dump_json().encode() + b"\n"
            return ChildProcess(line, _MODULE, descriptors)
