"""All hooks: each posts what it wants to know; whatever fails here stays here."""

from __future__ import annotations

import asyncio
import secrets
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import structlog

from wax.authority import client_tls
from wax.error_boundary import FirstErrorLogged
from wax.hooks.outbox import URGENT_WAIT_S, Message, Outbox
from wax.hooks.post import HookError, post, session
from wax.hooks.signature import read_secret
from wax.protocol.events import nameless
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    import ssl
    from collections.abc import Callable, Iterator, Sequence

    import aiohttp

    from wax.clock import Clock
    from wax.config.hook import HookSettings
    from wax.protocol.events import Event

_LOG = structlog.get_logger(__name__)

_LOOK_S: Final = 0.1
"""So often at most each hook posts: a hundred that waited are no burst."""
_URGENT: Final = ("stop.", "fault.")
_LAST_S: Final = 1.0
"""The end of the server waits no longer for the last events."""


class Hook:
    """One receiver; raises `StartError` if its secret cannot be read.

    `name` is its number in the configuration and its host: its path is nobody's business. What is
    `urgent` has a way of its own, each in order: it waits neither for `news` nor for what they
    wait for. A receiver that says it is `gone` is asked no more.
    """

    def __init__(self, number: int, settings: HookSettings, clock: Clock) -> None:
        self.name = f"{number} ({settings.host})"
        self.urgent, self.news = self.ways = (Outbox(URGENT_WAIT_S), Outbox())
        self.gone: Sentence | None = None
        self._refused_types: set[str] = set()
        self._settings = settings
        self._clock = clock
        self._secret = read_secret(settings.secret_file, f"hook[{number - 1}].secret_file")
        self._tls: ssl.SSLContext | bool = True
        if settings.ca_file:
            self._tls = client_tls(settings.ca_file, f"hook[{number - 1}].ca_file")

    def put(self, event: Event) -> None:
        """Have an event posted soon, if this hook asks for it."""
        if not self._settings.events or event.type in self._settings.events:
            way = self.urgent if event.type.startswith(_URGENT) else self.news
            way.put(self.message(event))
            if self.gone is not None:
                way.shut()

    def message(self, event: Event) -> Message:
        """Return an event as it is posted."""
        told = event if self._settings.names else nameless(event)
        body = told.model_dump_json().encode()
        return Message(f"msg_{secrets.token_hex(16)}", event.type, body, self._clock.now_s())

    async def post(
        self, http: aiohttp.ClientSession, message: Message, *, wants_answer: bool = False
    ) -> tuple[int, bytes]:
        """Try once; see `wax.hooks.post.post`."""
        return await post(
            http,
            self._settings.url,
            message,
            secret=self._secret,
            unix_s=self._clock.wall_ms() // 1000,
            tls=self._tls,
            wants_answer=wants_answer,
        )

    async def step(self, http: aiohttp.ClientSession) -> None:
        """Post what is due, if anything is: one of each way at a time; never raises."""
        await asyncio.gather(*(self._step(http, way) for way in self.ways))

    async def run(self, http: aiohttp.ClientSession) -> None:
        """Post until cancelled."""
        await asyncio.gather(*(self._run(http, way) for way in self.ways))

    async def empty(self, http: aiohttp.ClientSession) -> None:
        """Post all that waits, up to the first that is in vain."""
        await asyncio.gather(*(self._empty(http, way) for way in self.ways))

    async def _step(self, http: aiohttp.ClientSession, way: Outbox) -> None:
        message = way.due(self._clock.now_s())
        if message is not None:
            await self._try(http, way, message)

    async def _run(self, http: aiohttp.ClientSession, way: Outbox) -> None:
        while True:
            await self._step(http, way)
            await asyncio.sleep(_LOOK_S)

    async def _empty(self, http: aiohttp.ClientSession, way: Outbox) -> None:
        while (message := way.first) is not None and await self._try(http, way, message):
            pass

    async def _try(self, http: aiohttp.ClientSession, way: Outbox, message: Message) -> bool:
        """Return whether the next may follow."""
        try:
            await self.post(http, message)
        except HookError as error:
            failure = error
        except Exception as error:  # driving does not need it
            failure = HookError(says(repr(error)))
        else:
            way.took(message)
            return True
        if failure.is_gone:
            self._shut(failure.sentence)
        elif failure.is_final:
            if message.type not in self._refused_types:
                self._refused_types.add(message.type)
                self._log("a hook refuses an event", failure.sentence, message)
            way.refuse(message, failure.sentence)
        else:
            if self.problem is None:  # once until it takes one: it may fail for days
                self._log("a hook did not take an event", failure.sentence, message)
            way.failed(failure.sentence, self._clock.now_s(), failure.wait_s)
        return failure.is_final

    def _shut(self, why: Sentence) -> None:
        """Post nothing more: the receiver has said that it is gone."""
        if self.gone is None:
            _LOG.warning("a hook is off until the next start", hook=self.name, why=str(why))
        self.gone = why
        for way in self.ways:
            way.shut()

    def _log(self, what: str, why: Sentence, message: Message) -> None:
        _LOG.warning(what, hook=self.name, what=message.type, why=str(why))

    @property
    def waiting(self) -> int:
        return sum(map(len, self.ways))

    @property
    def lost(self) -> int:
        return sum(way.lost for way in self.ways)

    @property
    def refused(self) -> int:
        return sum(way.refused for way in self.ways)

    @property
    def problem(self) -> Sentence | None:
        """Why it does not take what is posted, or not what was posted last."""
        return self.gone or self.urgent.problem or self.news.problem

    def status(self) -> dict[str, object]:
        """Return it as the host's status page has it."""
        return {
            "name": self.name,
            "problem": None if self.problem is None else str(self.problem),
            "disabled": self.gone is not None,
            "waiting": self.waiting,
            "taken": sum(way.taken for way in self.ways),
            "refused": self.refused,
            "lost": self.lost,
        }

    def problems(self) -> Iterator[Sentence]:
        """Yield what the host is to know."""
        if self.gone is not None:
            yield Sentence("hook.disabled", {"hook": self.name, "why": self.gone})
            return
        if self.problem is not None and self.waiting:
            yield Sentence(
                "hook.waiting", {"hook": self.name, "n": self.waiting, "why": self.problem}
            )
        refusal = self.urgent.refusal or self.news.refusal
        if refusal is not None:
            yield Sentence("hook.refused", {"hook": self.name, "n": self.refused, "why": refusal})
        if self.lost:
            yield Sentence("hook.lost", {"hook": self.name, "n": self.lost})


class Hooks:
    """All of `[[hook]]`; without any, nothing here does anything. Raises `StartError`."""

    def __init__(
        self, settings: Sequence[HookSettings], clock: Clock, own_port: Callable[[], int]
    ) -> None:
        self._hooks = [Hook(number, one, clock) for number, one in enumerate(settings, 1)]
        self._own_port = own_port
        self._contained = FirstErrorLogged("events are lost")

    def put(self, event: Event) -> None:
        """Tell all who ask for it, soon; never raises."""
        with self._contained:
            for hook in self._hooks:
                hook.put(event)

    async def run(self) -> None:
        """Post until cancelled; never ends, since driving does not need it."""
        if self._hooks:
            with self._contained:
                async with session(self._own_port) as http:
                    await asyncio.gather(*(hook.run(http) for hook in self._hooks))
        await asyncio.Event().wait()

    async def close(self) -> None:
        """Try once more to post what waits; for a second at most, and never raises."""
        if any(hook.waiting for hook in self._hooks):
            with self._contained, suppress(TimeoutError):
                async with asyncio.timeout(_LAST_S), session(self._own_port) as http:
                    await asyncio.gather(*(hook.empty(http) for hook in self._hooks))

    def status(self) -> list[dict[str, object]]:
        """Return each hook as the host's status page has it."""
        return [one.status() for one in self._hooks]

    def problems(self) -> list[Sentence]:
        """Return what the host is to know."""
        return [what for one in self._hooks for what in one.problems()]
