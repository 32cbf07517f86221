"""The server's end of the driver process: a `Driver` that forwards every call to it."""

from __future__ import annotations

import math
import signal
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import structlog

from wax.config.local import LocalSettings
from wax.config.log import LogSettings
from wax.driver.checks import unit
from wax.driver.interface import RobotState
from wax.errors import ProtocolError
from wax.robot.process.child_process import ChildProcess
from wax.robot.process.driver_watchdog import COUNTS
from wax.robot.process.hand_watchdog import HAND_COUNTS
from wax.robot.process.kept_process import KeptProcess, RestartPauses
from wax.robot.process.pipe_messages import (
    Axis,
    Begin,
    Bye,
    Control,
    Halt,
    LineBuffer,
    Move,
    NotBuilt,
    Ready,
    StateReport,
    decode_answer,
    encode,
)
from wax.robot.process.resource_limits import ResourceUse
from wax.sentence import Sentence

if TYPE_CHECKING:
    import threading
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.config.controls import ControlSettings
    from wax.config.robot import RobotSettings
    from wax.driver.interface import ControlValue, Limits, Twist
    from wax.robot.process.pipe_messages import Message

_LOG = structlog.get_logger(__name__)

START_S: Final = 20.0
"""A plug-in's libraries may take long to load on a small machine."""
HUNG_S: Final = 1.0
LOOK_S: Final = 0.5
"""How often the process's use of memory and threads is checked."""
PAUSES: Final = RestartPauses(first_s=0.3, last_s=3.0, steady_s=5.0)
LATE_S: Final = 0.02
"""The process stops the robot this much after the server should have, so that a server whose loop
is no later than this stops it first."""
CLOSE_S: Final = 0.85
KILL_S: Final = 0.1

_CHANGED: Final = Sentence("robot.driver_changed")
_OURS: Final = ("driver_restarts", "driver_full", "driver_garbled")


class ProcessDriver(KeptProcess):
    """A `Driver` in its own process, which is restarted whenever it ends.

    The process stops the robot when the server is silent for `silence_ms`, frozen, or gone. `kind`
    and `limits` are those of the real driver. The state's `extra` has ``driver_pid`` and the
    counts, whose names also begin with ``driver_``.

    With a person aboard (`local`) the process outlives a server that dies; `claim` is the file by
    which the next server's process takes over. `close` ends the process, `abandon` does not.
    """

    def __init__(
        self,
        settings: RobotSettings,
        clock: Clock,
        *,
        kind: str,
        limits: Limits,
        log: LogSettings | None = None,
        local: LocalSettings | None = None,
        claim: str = "",
        controls: Sequence[ControlSettings] = (),
    ) -> None:
        super().__init__("driver process", clock.now_s, PAUSES)
        self._kind = kind
        self._limits = replace(limits, silence_s=settings.silence_ms / 1000)
        self._clock = clock
        local = local or LocalSettings()
        self._has_passenger = local.is_on
        self._begin = encode(
            Begin(
                robot=settings,
                log=log or LogSettings(),
                local=local,
                claim=claim,
                controls=list(controls),
            )
        )
        self._is_operated = False
        self._end_s: float | None = None
        self._listening: ChildProcess | None = None  # once it has reported
        self._sequence = 0
        self._state = RobotState(connected=False)
        self._epoch = 0
        self._childs_epoch: int | None = None
        hand_counts = HAND_COUNTS if local.is_on else ()
        self._past = Counter(dict.fromkeys((*COUNTS, *hand_counts, *_OURS), 0))
        self._counts: dict[str, int] = {}
        self._resource_use = ResourceUse()

    @property
    def kind(self) -> str:
        return self._kind

    @property
    def limits(self) -> Limits:
        return self._limits

    def open(self) -> None:
        """Start the process in the background; no effect if already open."""
        self._start()

    def tell_passenger(self, *, is_operated: bool) -> None:
        with self._lock:
            self._is_operated = is_operated

    def set_deadline(self, end_s: float) -> None:
        with self._lock:
            self._end_s = end_s + LATE_S if math.isfinite(end_s) else None

    def apply(self, twist: Twist, turn: int) -> None:
        with self._lock:
            self._say(
                Move(
                    sequence=self._sequence,
                    sent_s=self._clock.now_s(),
                    turn=turn,
                    linear_mps=twist.linear_mps,
                    angular_rps=twist.angular_rps,
                    lateral_mps=twist.lateral_mps,
                    operated=self._is_operated,
                    end_s=self._end_s,
                )
            )

    def set_axis(self, name: str, position: float, turn: int) -> None:
        if name not in self._limits.axes:
            return
        with self._lock:
            self._say(
                Axis(
                    sequence=self._sequence,
                    sent_s=self._clock.now_s(),
                    turn=turn,
                    name=name,
                    position=unit(position),
                )
            )

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        if name not in self._limits.controls:
            return
        with self._lock:
            self._say(
                Control(
                    sequence=self._sequence,
                    sent_s=self._clock.now_s(),
                    turn=turn,
                    name=name,
                    value=value,
                )
            )

    def stop(self, turn: int) -> None:
        with self._lock:
            self._say(Halt(sequence=self._sequence, sent_s=self._clock.now_s(), turn=turn))

    def close(self) -> None:
        thread = self._thread
        if thread is None:
            return
        if not self._end(CLOSE_S):
            self._kill()
            thread.join(KILL_S)
        self._thread = None

    def abandon(self) -> None:
        """Leave the process as a dying server would: with a person aboard it keeps running."""
        if not self._has_passenger:
            self.close()
            return
        self._thread = None
        self._is_abandoned = True
        self._closing.set()
        with self._lock:
            if self._child is not None:
                self._child.hang_up()

    def state(self) -> RobotState:
        with self._lock:
            counts = self._past + Counter(self._counts)
            extra = self._state.extra | {name: float(counts[name]) for name in self._past}
            if self._child is not None:
                extra["driver_pid"] = self._child.pid
            return replace(self._state, extra=extra)

    def _say(self, message: Message) -> None:
        """Send a message, with the lock held; skip it while the process is still starting."""
        self._sequence += 1
        if self._child is None or self._child is not self._listening:
            return
        if not self._child.send(encode(message)):
            # The process does not read, so a stop would not reach it: the robot's watchdog acts.
            self._past["driver_full"] += 1
            self._child.kill()

    def _dismiss(self, child: ChildProcess) -> None:
        """Tell the process to end, with the lock held."""
        if self._has_passenger:
            child.send(encode(Bye()))
        child.hang_up()

    # --- the process's life, in a thread ----------------------------------------------------

    def _spawn(self) -> ChildProcess:
        return ChildProcess(self._begin)

    def _not_started(self, why: str) -> Sentence:
        return Sentence("robot.driver_not_started", {"why": why})

    def _watch(self, child: ChildProcess, closing: threading.Event) -> Sentence | None:  # noqa: ARG002
        """Receive states; return a sentence if the process must be ended, None if it has ended."""
        lines = LineBuffer()
        deadline_s = self._clock.now_s() + START_S
        look_s = 0.0
        while (data := child.receive(deadline_s - self._clock.now_s())) is not None:
            if self._is_abandoned:
                return None
            for line in lines.feed(data):
                problem, is_valid = self._hear(line)
                if problem is not None:
                    return problem
                if is_valid:
                    deadline_s = self._clock.now_s() + HUNG_S
            now_s = self._clock.now_s()
            if now_s >= look_s:
                look_s = now_s + LOOK_S
                if (excess := self._resource_use.excess(child.pid)) is not None:
                    return Sentence("robot.driver_greedy", {"what": excess})
            if not data and now_s >= deadline_s:
                child.kill()
                return Sentence("robot.driver_hangs")
        return None

    def _hear(self, line: bytes) -> tuple[Sentence | None, bool]:
        """Handle its lines; return why it must be ended, if it must, and whether all were valid."""
        try:
            answer = decode_answer(line)
        except ProtocolError:
            with self._lock:
                self._past["driver_garbled"] += 1
            return None, False
        if isinstance(answer, NotBuilt):
            return Sentence("robot.driver_not_built", {"why": answer.why}), True
        if isinstance(answer, StateReport):
            self._take(answer)
        elif not self._is_same(answer):
            return _CHANGED, True
        return None, True

    def _is_same(self, ready: Ready) -> bool:
        # The process's limits lack `silence_s`, its own timeout for a silent server.
        limits = replace(ready.limits, silence_s=self._limits.silence_s)
        return (ready.kind, limits) == (self._kind, self._limits)

    def _take(self, told: StateReport) -> None:
        with self._lock:
            if told.state.epoch != self._childs_epoch:
                self._childs_epoch = told.state.epoch
                self._epoch += 1
            self._state = replace(told.state, epoch=self._epoch)
            self._counts = told.counts
            self._listening = self._child

    def _lost(self, problem: Sentence, *, is_over: bool) -> None:
        with self._lock:
            shown = None if is_over else problem
            self._state = RobotState(connected=False, problem=shown, epoch=self._epoch)
            self._childs_epoch = None
            self._past.update(self._counts)
            self._counts = {}
            self._past["driver_restarts"] += not is_over

    def _ended(self, status: int) -> Sentence:
        if status == -signal.SIGALRM:  # by which the process ends itself when its driver hangs
            return Sentence("robot.driver_hangs")
        if status < 0:
            return Sentence("robot.driver_killed", {"signal": -status})
        return Sentence("robot.driver_ended", {"status": status})
