"""Speak the dialect ``text``: lines that the host describes by templates (pure).

Many sketches and motor controllers are driven by lines of text. Only the host knows whether one has
a watchdog (`ttl_ms`), so every line is repeated, standstill as well, in case one is lost. A line is
written only after the previous one has left the port, so that no stale line is buffered on a slow
port.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.config.line_template import LineTemplate
from wax.config.text_dialect import DRIVEN, POSITION
from wax.driver.checks import within
from wax.driver.interface import STANDSTILL, Reading
from wax.logs.printable import printable
from wax.robot.serial.text_lines import Lines, Reports
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Limits, Twist
    from wax.robot.line.setpoints import Order
    from wax.robot.wheels import WheelMixer

FAREWELLS: Final = 3
"""How many stops are sent before closing, since none is repeated afterwards."""
SHOWN_CHARS: Final = 40
_BUSY_S: Final = 0.05
"""If sending takes longer than this, only one line may be in the port's buffer."""
_BITS_A_BYTE: Final = 10
"""Including the start and stop bits."""


class TextDialect:
    """A `Dialect` for boards that understand lines of text.

    A connection begins with stops while the board boots (`boot_ms`), or until its first answer if
    `answers` says that it gives any; then the lines of `begin` follow. After that, a board that
    should answer and does not counts as lost, and the connection starts over.
    """

    def __init__(self, settings: RobotSettings, mixer: WheelMixer, limits: Limits) -> None:
        own = settings.serial.text
        self._own = own
        self._mixer, self._limits = mixer, limits
        self._byte_s = _BITS_A_BYTE / settings.serial.baud
        self._drive = LineTemplate(own.drive, DRIVEN)
        # End any incomplete line that is still in the board's buffer.
        self._flush = self._drive.ending.encode("ascii")
        self._stop = own.stop.encode("ascii") or self._driven(STANDSTILL)
        self._begin = "".join(own.begin).encode("ascii")
        self._end = "".join(own.end).encode("ascii")
        self._ask = [line.encode("ascii") for line in own.ask]
        self._answer = LineTemplate(own.answers, ()) if own.answers else None
        self._axes = {
            name: (LineTemplate(axis.line, (POSITION,)), axis.least, axis.most)
            for name, axis in zip(limits.axes, own.axis, strict=True)
        }
        self._reports = Reports(settings)
        self._forget(-math.inf)

    def hello(self, now_s: float) -> bytes:
        self._forget(now_s)
        return self._sent(self._flush + self._repeated(self._stop, now_s), now_s)

    def data_to_send(self, order: Order, now_s: float) -> tuple[bytes, float]:
        self._now_s = now_s
        if self._has_begun and self.overdue(now_s):
            return self.hello(now_s), self._due_s()
        if now_s < self._free_s:
            return b"", self._free_s
        if not self._has_begun:
            words = self._wake(now_s)
        elif not self.answers(now_s):
            words = self._repeated(self._stop, now_s)
        else:
            words = self._motion(order, now_s)
            words += self._moved_axes(order, words)
            words += self._question(words, now_s)
        return self._sent(words, now_s), self._due_s()

    def farewell(self) -> bytes:
        return self._flush + self._stop * FAREWELLS + self._end

    def receive_data(self, data: bytes, now_s: float) -> None:
        self._now_s = now_s
        for line in self._lines.feed(data):
            is_report = self._reports.parse_line(line, now_s)
            if self._answer is not None and self._answer.found(line) is not None:
                self._answered_s, self._last_strange = now_s, ""
            elif not is_report:
                self._strange += 1
                self._last_strange = line

    def answers(self, now_s: float) -> bool:
        has_answered = self._answer is None or self._answered_s > self._begun_s
        return self._has_begun and has_answered and not self.overdue(now_s)

    def overdue(self, now_s: float) -> bool:
        return now_s >= self._patience_ends_s()

    def complaint(self, port: str) -> Sentence:
        """Return why the board counts as lost, and what to do."""
        if self._last_strange:
            said = printable(self._last_strange, SHOWN_CHARS)
            return Sentence("robot.other_answer", {"port": port, "said": said})
        return Sentence("robot.no_lines", {"port": port})

    @property
    def reading(self) -> Reading:
        reports, now_s = self._reports, self._now_s
        return Reading(
            moving=reports.moving(now_s),
            pose=reports.pose,
            bumpers=reports.bumpers(now_s),
            battery_v=reports.battery_v(now_s),
            extra=reports.known() | {"strange_lines": float(self._strange)},
        )

    def _forget(self, now_s: float) -> None:
        self._lines = Lines()
        self._reports.forget()
        self._strange, self._last_strange = 0, ""
        self._has_begun = False
        self._begun_s = self._answered_s = -math.inf
        self._boots_until_s = now_s + self._own.boot_ms / 1000.0
        self._said, self._turn = b"", 0
        self._said_axes: dict[str, bytes] = {}
        self._now_s = self._free_s = self._again_s = now_s
        self._ask_s, self._asked = math.inf, 0

    def _wake(self, now_s: float) -> bytes:
        """Send stop until the board listens, then the lines of `begin`, then stop once more."""
        listens = now_s >= self._boots_until_s if self._answer is None else self._has_heard_it
        if listens:
            self._has_begun, self._begun_s, self._said = True, now_s, b""
            self._ask_s = now_s if self._ask else math.inf
        return (self._begin if listens else b"") + self._repeated(self._stop, now_s)

    def _motion(self, order: Order, now_s: float) -> bytes:
        line = self._stop if order.twist.is_zero else self._driven(order.twist)
        is_new_turn, self._turn = order.turn > self._turn, order.turn
        if is_new_turn and self._stop not in (self._said, line):
            # A starved process may have skipped the stop between two turns.
            self._said = self._stop
            return self._stop + self._repeated(line, now_s)
        return self._repeated(line, now_s)

    def _repeated(self, line: bytes, now_s: float) -> bytes:
        """Return the line if it is new, or was last sent long enough ago."""
        if line == self._said and now_s < self._again_s:
            return b""
        self._said, self._again_s = line, now_s + self._own.keep_alive_ms / 1000.0
        return line

    def _moved_axes(self, order: Order, before: bytes) -> bytes:
        words = b""
        for name, position in order.axes:
            template, least, most = self._axes[name]
            line = template.said({POSITION: least + (position + 1.0) / 2.0 * (most - least)})
            if line != self._said_axes.get(name) and self._has_room(before + words, line):
                words += line
                self._said_axes[name] = line
        return words

    def _question(self, before: bytes, now_s: float) -> bytes:
        question = self._ask[(self._asked + 1) % len(self._ask)] if self._ask else b""
        if now_s < self._ask_s or not self._has_room(before, question):
            return b""
        self._ask_s = now_s + self._own.ask_ms / 1000.0
        self._asked += 1
        return question

    def _has_room(self, before: bytes, line: bytes) -> bool:
        """Whether this line would not delay the next stop for long, on a slow port."""
        return not before or (len(before) + len(line)) * self._byte_s <= _BUSY_S

    def _sent(self, words: bytes, now_s: float) -> bytes:
        self._free_s = now_s + len(words) * self._byte_s
        return words

    def _due_s(self) -> float:
        ends_s = (self._boots_until_s, self._patience_ends_s())
        coming_s = [at_s for at_s in ends_s if at_s > self._now_s]  # ignore lines already sent
        return max(self._free_s, min(self._again_s, self._ask_s, *coming_s))

    def _patience_ends_s(self) -> float:
        """When the board counts as lost; never if it need not answer."""
        if self._answer is None:
            return math.inf
        begins_s = max(self._begun_s, self._answered_s) if self._has_begun else self._boots_until_s
        return begins_s + self._own.answer_ms / 1000.0

    @property
    def _has_heard_it(self) -> bool:
        return math.isfinite(self._answered_s)

    def _driven(self, twist: Twist) -> bytes:
        """Return the line for a motion; if a number exceeds the limit, all are scaled down."""
        allowed, wheels = within(twist, self._limits), self._mixer.mix(twist)
        values = {wheel: speed * self._own.per_mps for wheel, speed in wheels.items()}
        values |= {
            "linear": allowed.linear_mps * self._own.per_mps,
            "lateral": allowed.lateral_mps * self._own.per_mps,
            "angular": allowed.angular_rps * self._own.per_rps,
        }
        largest = max(abs(values[name]) for name in self._drive.names)
        share = min(1.0, self._own.limit / largest) if self._own.limit and largest else 1.0
        return self._drive.said({name: value * share for name, value in values.items()})
