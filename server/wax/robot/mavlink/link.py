"""The messages of a conversation, carried by whichever line the rover is on."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from wax.robot.line.kept_line import RobotLine
from wax.robot.mavlink.line import open_line, why_closed, why_lost

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.robot.mavlink.conversation import Conversation
    from wax.robot.mavlink.line import MavlinkLine
    from wax.robot.mavlink.settings import MavlinkSettings
    from wax.sentence import Sentence


class MavlinkLink(RobotLine):
    """A `MavlinkLine`, on which a stop overtakes what is queued."""

    hears: ClassVar[bool] = True
    _line: MavlinkLine

    def __init__(self, settings: MavlinkSettings, clock: Clock, conversation: Conversation) -> None:
        self._settings = settings
        self._clock = clock
        self._conversation = conversation

    def start(self) -> None:
        self._conversation.start()

    def open(self, wake: Callable[[], None]) -> None:  # noqa: ARG002 - of the base class
        self._line = open_line(self._settings)

    def begin(self, now_s: float) -> None:
        self._conversation.opened(now_s)

    def step(self, now_s: float) -> float:
        words, due_s, is_stop = self._conversation.next(now_s)
        if is_stop:
            self._line.stop(words)
        elif words:
            self._line.write(words)
        return due_s

    def hear(self) -> bool:
        data = self._line.read()
        if data and self._conversation.received(data, self._clock.now_s()):
            self._line.answer()
        return bool(data)

    def leave(self, now_s: float) -> float:
        return self._conversation.farewell(now_s)

    def last_words(self, error: Exception) -> None:  # noqa: ARG002 - whatever it was
        if words := self._conversation.last_words(self._clock.now_s()):
            self._line.stop(words)

    def close(self) -> None:
        self._line.close()

    def problem(self, error: Exception, *, was_open: bool) -> Sentence:
        return (why_lost if was_open else why_closed)(self._settings, error)
