"""The state of the rover, and why it may not be driven now (pure)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.driver.interface import Pose
from wax.robot.mavlink.failsafe import QUESTIONS, broken, obeys_another, promise, told_s
from wax.robot.mavlink.news import (
    AUTOPILOT,
    Attitude,
    Battery,
    HeardMessage,
    Heartbeat,
    News,
    Parameter,
    Position,
    Speed,
)
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.robot.mavlink.failsafe import Promise
    from wax.robot.mavlink.settings import MavlinkSettings

SILENT_S: Final = 2.5
"""The heartbeat timeout: they come once a second, and one may be lost."""
TELEMETRY_SILENT_S: Final = 1.0
"""The least timeout for a rover that reports speed and attitude; a few reports may be lost, too."""
MAY_LOSE: Final = 4
ASK_FOR_S: Final = 2.0
"""How long to wait for unanswered parameters: older firmware lacks some of them."""
TURNING_RPS: Final = 0.05
REBOOT_MS: Final = 1000
"""If the time since power-on falls by more than this, the rover has restarted."""

BATTERY_OLD_S: Final = 5.0
"""Two messages report the battery, once a second each; a value older than this is unknown."""

_Told = tuple[float | None, float]
_UNTOLD: Final[_Told] = (None, -math.inf)

_ARDUPILOT: Final = 3
_GROUND_STATION: Final = 6
_ROVER_KINDS: Final = (10, 11)
"""Ground rover and boat; both run the same firmware."""

MODES: Final = {
    0: "MANUAL",
    1: "ACRO",
    3: "STEERING",
    4: "HOLD",
    5: "LOITER",
    6: "FOLLOW",
    7: "SIMPLE",
    8: "DOCK",
    9: "CIRCLE",
    10: "AUTO",
    11: "RTL",
    12: "SMART_RTL",
    15: "GUIDED",
    16: "INITIALISING",
}
"""The modes of ArduPilot's rovers."""

NUMBERS: Final = {name.lower(): number for number, name in MODES.items()}


class Rover:
    """Fed with every message on the line; `restarted` says that the rover has restarted."""

    def __init__(self, settings: MavlinkSettings) -> None:
        self._settings = settings
        self.begin(-math.inf)

    def begin(self, now_s: float) -> None:
        """Forget everything: the line was opened, the rover was lost, or it has restarted."""
        self._heard_s = -math.inf
        self._telemetry_s = -math.inf
        self._began_s = now_s
        self._beat: Heartbeat | None = None
        self._parameters: dict[str, float] = {}
        self._asks_end_s = math.inf
        self._told_s: dict[type[News], float] = {}
        self._speed_mps: float | None = None
        self._attitude: Attitude | None = None
        self._position: Position | None = None
        self._volts = self._fraction = _UNTOLD
        self._other: int | None = None
        self._has_twin = False
        self._signs = False
        self.restarted = False

    def handle_message(self, heard: HeardMessage, now_s: float) -> bool:
        """Handle a message; return whether it came from the rover's autopilot."""
        news = heard.news
        if heard.system == self._settings.own_system:
            self._has_twin = self._has_twin or isinstance(news, Heartbeat)
            return False
        if heard.system != self._settings.system:
            if isinstance(news, Heartbeat) and news.kind != _GROUND_STATION:
                self._other = heard.system
            return False
        if heard.component != AUTOPILOT:
            return False  # a camera or a companion computer, which may outlive the autopilot
        self._signs = heard.is_signed
        self._heard_s = now_s
        if news is not None:
            self._told_s[type(news)] = now_s
            self._take(news, now_s)
        return True

    def _take(self, news: News, now_s: float) -> None:
        match news:
            case Heartbeat():
                if self._beat is None:
                    self._asks_end_s = now_s + ASK_FOR_S
                self._beat = news
            case Parameter():
                self._parameters[news.name] = news.value
            case Speed():
                self._speed_mps, self._telemetry_s = news.mps, now_s
            case Attitude():
                last = self._attitude
                if last is not None and news.boot_ms < last.boot_ms - REBOOT_MS:
                    self.restarted = True
                self._attitude, self._telemetry_s = news, now_s
            case Position():
                self._position = news
            case Battery():
                self._volts = _newer(self._volts, news.volts, now_s)
                self._fraction = _newer(self._fraction, news.fraction, now_s)

    # --- is it there ------------------------------------------------------------------------

    @property
    def silent_at_s(self) -> float:
        """When it counts as lost without another message; minus infinity before the first."""
        if self._beat is None:
            return -math.inf
        if self._telemetry_s == -math.inf:
            return self._heard_s + SILENT_S
        steady_s = MAY_LOSE / self._settings.telemetry_hz
        return self._heard_s + min(SILENT_S, max(TELEMETRY_SILENT_S, steady_s))

    def answers(self, now_s: float) -> bool:
        """Whether its messages arrive."""
        return now_s < self.silent_at_s

    def unasked(self, now_s: float) -> tuple[str, ...]:
        """Return the parameters still to be requested; none after the timeout."""
        if self._beat is None or now_s >= self._asks_end_s:
            return ()
        return tuple(
            name
            for names in QUESTIONS
            if not any(name in self._parameters for name in names)
            for name in names
        )

    def told_since(self, kind: type[News], since_s: float) -> bool:
        """Whether news of this kind has arrived since then."""
        return self._told_s.get(kind, -math.inf) >= since_s

    @property
    def asks_end_s(self) -> float:
        """When unanswered requests time out; infinite before the first heartbeat."""
        return self._asks_end_s

    # --- may it be driven -------------------------------------------------------------------

    @property
    def promise(self) -> Promise:
        """What it promises to do when it loses us."""
        return promise(self._parameters, is_guided=self._settings.mode == "guided")

    @property
    def told_s(self) -> float | None:
        """How long after losing us it says that it stops, 0 for never, None if unknown."""
        return told_s(self._parameters, self.promise)

    def absent(self, now_s: float, refused: int) -> Sentence | None:
        """Return why it is not connected; `refused` counts messages without a valid signature."""
        settings = self._settings
        if not self.answers(now_s):
            if self._beat is None and now_s < self._began_s + SILENT_S:
                return Sentence("mavlink.listening", {"link": settings.url})
            if refused:
                return Sentence("mavlink.unsigned", {"link": settings.url})
            if self._other is not None:
                return Sentence(
                    "mavlink.other_system",
                    {
                        "heard": str(self._other),
                        "system": str(settings.system),
                        "link": settings.url,
                    },
                )
            return Sentence(
                "mavlink.silent", {"system": str(settings.system), "link": settings.url}
            )
        if self.unasked(now_s):
            return Sentence("mavlink.asking")
        return None

    def unfit(self) -> Sentence | None:
        """Return why a connected rover cannot be driven, and what to do."""
        settings, beat = self._settings, self._beat
        if beat is None:
            return Sentence("mavlink.asking")
        if self._has_twin:
            return Sentence("mavlink.twin", {"own": str(settings.own_system), "link": settings.url})
        if self._signs and not settings.signing_key:
            return Sentence("mavlink.signed")
        if beat.autopilot != _ARDUPILOT or beat.kind not in _ROVER_KINDS:
            return Sentence("mavlink.no_rover", {"system": str(settings.system)})
        return (
            obeys_another(self._parameters, settings.own_system)
            or broken(self.promise, settings.failsafe_s)
            or self._wrong_state(beat)
        )

    def _wrong_state(self, beat: Heartbeat) -> Sentence | None:
        wanted = NUMBERS[self._settings.mode]
        if beat.mode != wanted:
            mode = MODES.get(beat.mode, str(beat.mode))
            return Sentence("mavlink.wrong_mode", {"mode": mode, "wanted": MODES[wanted]})
        if not beat.is_armed:
            return Sentence("mavlink.disarmed")
        return None

    # --- what it tells ----------------------------------------------------------------------

    @property
    def moving(self) -> bool | None:
        """Whether it moves or turns, by its own sensors; None if it does not report its speed."""
        turn_rps = None if self._attitude is None else self._attitude.turn_rps
        if turn_rps is not None and abs(turn_rps) > TURNING_RPS:
            return True
        if self._speed_mps is None:
            return None
        return self._speed_mps >= self._settings.moving_mps

    @property
    def pose(self) -> Pose | None:
        """Its position relative to its origin; the heading is counted from north to the left."""
        if self._position is None or self._attitude is None:
            return None
        x_m, y_m, heading = self._position.x_m, self._position.y_m, self._attitude.heading_rad
        if x_m is None or y_m is None or heading is None:
            return None
        return Pose(x_m, y_m, heading)

    @property
    def battery(self) -> Battery:
        """Its main battery."""
        return Battery(self._volts[0], self._fraction[0])

    def known(self) -> dict[str, float]:
        """Return numbers for the status page."""
        known = {}
        if self._beat is not None:
            known = {"mode": float(self._beat.mode), "armed": float(self._beat.is_armed)}
        if self._speed_mps is not None:
            known["speed_mps"] = self._speed_mps
        if self._parameters and (stops_s := self.promise.stops_s) is not None:
            known["failsafe_s"] = stops_s
        return known | {
            name.lower(): value
            for name, value in self._parameters.items()
            if name.startswith(("FS_", "GUID_"))
        }


def _newer(last: _Told, value: float | None, now_s: float) -> _Told:
    """Keep a value from one message while another reports none, but not for ever."""
    if value is not None:
        return value, now_s
    return last if now_s - last[1] < BATTERY_OLD_S else _UNTOLD
