"""Publishes states and events to the broker, and decides which of its messages are obeyed."""

from __future__ import annotations

import asyncio
import json
import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import structlog

from wax import __version__
from wax.error_boundary import FirstErrorLogged
from wax.errors import ForbiddenError, StartError
from wax.house import commands
from wax.house.commands import OFF, ON
from wax.house.discovery import birth_topic, command_topic, discovery, topic_of, way_topic
from wax.protocol.events import FaultEvent, StopEvent, StoppedByItself, nameless
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from wax.clock import Clock
    from wax.config.settings import Settings
    from wax.house.broker import BrokerLink
    from wax.house.commands import HouseAct
    from wax.protocol.events import Event

_LOG = structlog.get_logger(__name__)

UNKNOWN: Final = "None"
"""The payload that Home Assistant shows as an unknown state."""
GAP_S: Final = 0.2
"""Messages of one topic act at most this often: the first at once, then the newest."""
_STOP_GAP_S: Final = 0.04
"""The same for Stop, which must act within 100 ms even right after another."""
_REFRESH_S: Final = 1.0
_CLOSE_S: Final = 1.0
_REFUSAL_SHOWN_S: Final = 60.0
"""How long the host sees that a command was refused: nobody at home reads why."""


def broker_link(
    settings: Settings, clock: Clock, deliver: Callable[[str, bytes, bool], None] = lambda *_: None
) -> BrokerLink:
    """Return a link that passes every command to `deliver`; raises `StartError`."""
    try:
        from wax.house.broker import BrokerLink  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise StartError(
            'mqtt.url: the library for MQTT is missing; type: pip install "wax-teleop[mqtt]"'
        ) from error
    topic, may_release = topic_of(settings), settings.mqtt.release
    names = [name for name in commands.NAMES if name != commands.RELEASE or may_release]
    asks = {command_topic(topic, name): way_topic(topic, name) for name in names}
    birth = birth_topic(settings)
    return BrokerLink(settings.mqtt, clock, topic=topic, asks=asks, birth=birth, deliver=deliver)


class House:
    """The integration of `[mqtt]`, idle without its `url`. Raises `StartError`.

    `seen` returns the polled states by the last levels of their topics; `act` carries out a command
    or raises `ForbiddenError`.
    """

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        *,
        seen: Callable[[], Mapping[str, str]],
        act: Callable[[HouseAct], None],
    ) -> None:
        self._settings = settings.mqtt
        self._clock = clock
        self._seen = seen
        self._act = act
        self._topic = topic_of(settings)
        self._announced: dict[str, str] = {}
        if self._settings.discovery:
            where, what = discovery(settings, __version__)
            self._announced[where] = json.dumps(what, ensure_ascii=False)
        self._faults: set[tuple[str, str | None]] = set()
        self._last_stop = UNKNOWN, UNKNOWN
        self._loop: asyncio.AbstractEventLoop | None = None
        self._lock = threading.Lock()
        self._newest: dict[str, bytes] = {}
        self._acted_s: dict[str, float] = {}
        self._is_garbage_told = False
        self._refused: tuple[float, Sentence] | None = None
        self.counts = dict.fromkeys(("retained", "overtaken", "garbage", "refused"), 0)
        self._contained = FirstErrorLogged("the house is not told")
        self._link = None
        if self._settings.url:
            self._link = broker_link(settings, clock, self.receive)

    def put(self, event: Event) -> None:
        """Enqueue an event; never raises."""
        if self._link is None:
            return
        with self._contained:
            self._note(event)
            told = event if self._settings.names else nameless(event)
            self._link.put(told.model_dump_json())

    async def run(self) -> None:
        """Refresh the states until cancelled; no failure ends it: driving does not depend on it."""
        if self._link is not None:
            self._loop = asyncio.get_running_loop()
            self._refresh_states()
            self._link.start()
        while True:
            await asyncio.sleep(_REFRESH_S)
            self._refresh_states()

    async def close(self) -> None:
        """Disconnect from the broker, within a second."""
        if self._link is not None:
            await asyncio.to_thread(self._link.close, _CLOSE_S)

    def status(self) -> dict[str, object] | None:
        """Return the entry for the host's status page; None without a broker."""
        link = self._link
        if link is None:
            return None
        why = link.troubles if link.problem is None else [link.problem]
        return {
            "broker": link.name,
            "connected": link.is_connected,
            "problem": " ".join(str(one) for one in why) or None,
            "lost": link.lost + link.expired,
            **self.counts,
        }

    def problems(self) -> list[Sentence]:
        """Return the problems to show to the host."""
        link = self._link
        if link is None:
            return []
        if link.problem is not None:
            return [Sentence("house.away", {"broker": link.name, "why": link.problem})]
        told = list(link.troubles)
        if self._refused is not None and self._clock.now_s() - self._refused[0] < _REFUSAL_SHOWN_S:
            told.append(Sentence("house.act_refused", {"why": self._refused[1]}))
        return told

    def _note(self, event: Event) -> None:
        match event:
            case FaultEvent(type="fault.began"):
                self._faults.add((event.part, event.which))
            case FaultEvent():
                self._faults.discard((event.part, event.which))
            case StopEvent(type="stop.pressed"):
                self._last_stop = event.timestamp, f"pressed ({event.role})"
            case StoppedByItself():
                self._last_stop = event.timestamp, event.why

    def _refresh_states(self) -> None:
        if self._link is None:
            return
        with self._contained:
            states = dict(self._seen())
            states["fault"] = ON if self._faults else OFF
            states["last_stop"], states["last_stop_reason"] = self._last_stop
            told = {f"{self._topic}/{key}": value for key, value in states.items()}
            self._link.states = self._announced | told

    # --- what comes in -----------------------------------------------------------------------

    def receive(self, topic: str, payload: bytes, is_retained: bool) -> None:
        """Receive a message in the broker's thread; only a few of a flood reach the event loop.

        A retained copy is an old wish, and would act again at each new connection. That holds for
        Stop, too: people would soon do without a broker that stops the robot whenever it is back.
        An empty message deletes a retained one, or is a press without a payload: in doubt, an empty
        Stop stops.
        """
        loop = self._loop
        if loop is None:
            return
        name = topic.removeprefix(f"{self._topic}/").removesuffix("/set")
        if is_retained or not (payload or name == commands.STOP):
            self.counts["retained"] += 1
            return
        if name not in commands.NAMES:  # not subscribed to; `_newest` must not grow with names
            return
        with self._lock:
            is_awaited = name in self._newest
            self._newest[name] = payload
        if is_awaited:
            self.counts["overtaken"] += 1
            return
        with suppress(RuntimeError):  # the server has ended meanwhile
            loop.call_soon_threadsafe(self._schedule, loop, name)

    def _schedule(self, loop: asyncio.AbstractEventLoop, name: str) -> None:
        since_s = self._clock.now_s() - self._acted_s.get(name, float("-inf"))
        rest_s = (_STOP_GAP_S if name == commands.STOP else GAP_S) - since_s
        if rest_s <= 0:
            self._act_on_newest(name)
        else:
            loop.call_later(rest_s, self._act_on_newest, name)

    def _act_on_newest(self, name: str) -> None:
        self._acted_s[name] = self._clock.now_s()
        with self._lock:
            payload = self._newest.pop(name)
        with self._contained:
            act = commands.parse(name, payload)
            if act is None:
                self.counts["garbage"] += 1
                if not self._is_garbage_told:
                    self._is_garbage_told = True
                    _LOG.warning("a message by MQTT is none of ours", topic=name)
                return
            try:
                self._act(act)
            except ForbiddenError as error:
                self.counts["refused"] += 1
                self._refused = self._clock.now_s(), error.sentence
                _LOG.warning("refused by MQTT", topic=name, why=str(error))
        self._refresh_states()
