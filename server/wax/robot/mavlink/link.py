"""Keeps a line open: one thread opens it and writes, another reads."""

from __future__ import annotations

import math
import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from wax.robot.mavlink.line import open_line, why_closed, why_lost

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.robot.mavlink.conversation import Conversation
    from wax.robot.mavlink.line import MavlinkLine
    from wax.robot.mavlink.settings import MavlinkSettings
    from wax.sentence import Sentence

CLOSE_TIMEOUT_S: Final = 0.8
LONGEST_PAUSE_S: Final = 1.0


class MavlinkLink:
    """One line, kept open from `open` to `close`, and reopened after failures."""

    def __init__(self, settings: MavlinkSettings, clock: Clock, conversation: Conversation) -> None:
        self._settings = settings
        self._clock = clock
        self._conversation = conversation
        self._changed = threading.Condition()
        self._news = False
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._error: Exception | None = None

    def open(self) -> None:
        """Start opening the line and keep trying; no effect if already started."""
        if self._thread is not None:
            return
        self._conversation.start()
        self._closing = threading.Event()
        self._thread = threading.Thread(
            target=self._keep, args=(self._closing,), name="mavlink", daemon=True
        )
        self._thread.start()

    def wake(self) -> None:
        """Call the conversation's `next` now."""
        with self._changed:
            self._news = True
            self._changed.notify()

    def close(self) -> None:
        """Send the farewell and close the line; takes at most a second, safe to call twice."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._closing.set()
        self.wake()
        thread.join(CLOSE_TIMEOUT_S)

    def _keep(self, closing: threading.Event) -> None:
        while not closing.is_set():
            problem = self._use(closing)
            self._conversation.lost(None if closing.is_set() else problem)
            closing.wait(self._settings.reopen_s)

    def _use(self, closing: threading.Event) -> Sentence | None:
        """Open the line and use it until it is closed or lost; return why it was lost."""
        try:
            line = open_line(self._settings)
        except Exception as error:  # whatever a port's driver or a name lookup raises
            return why_closed(self._settings, error)
        ended = threading.Event()
        self._error = None
        self._conversation.opened(self._clock.now_s())
        reader = threading.Thread(
            target=self._read, args=(line, ended), name="mavlink reader", daemon=True
        )
        reader.start()
        try:
            self._write(line, closing)
        except Exception as error:  # as above
            with suppress(Exception):  # often only one direction is lost
                if words := self._conversation.last_words(self._clock.now_s()):
                    line.stop(words)
            return why_lost(self._settings, error)
        finally:
            ended.set()
            reader.join()
            line.close()
        return None

    def _write(self, line: MavlinkLine, closing: threading.Event) -> None:
        ends_s = math.inf
        while True:
            with self._changed:
                self._news = False
            now_s = self._clock.now_s()
            if closing.is_set() and ends_s == math.inf:
                ends_s = now_s + self._conversation.farewell(now_s)
            words, due_s, is_stop = self._conversation.next(now_s)
            if is_stop:
                line.stop(words)
            elif words:
                line.write(words)
            if self._clock.now_s() >= ends_s:
                return
            with self._changed:
                pause_s = min(due_s, ends_s) - self._clock.now_s()
                self._changed.wait_for(self._must_act, min(max(0.0, pause_s), LONGEST_PAUSE_S))
            if self._error is not None:
                raise self._error

    def _must_act(self) -> bool:
        return self._news or self._error is not None

    def _read(self, line: MavlinkLine, ended: threading.Event) -> None:
        try:
            while not ended.is_set():
                data = line.read()
                if not data:
                    continue
                if self._conversation.received(data, self._clock.now_s()):
                    line.answer()
                self.wake()
        except Exception as error:  # the writer ends with it and reports it
            with self._changed:
                self._error = error
                self._changed.notify()
