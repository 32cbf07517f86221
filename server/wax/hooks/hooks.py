"""Webhooks: each posts the events that it subscribes to; no failure leaves this module."""

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

_POLL_S: Final = 0.1
"""Each hook posts at most this often, so that a backlog of a hundred is no burst."""
_URGENT: Final = ("stop.", "fault.")
_FLUSH_S: Final = 1.0
"""The server's shutdown waits at most this long for the last events."""


class Hook:
    """One receiver; raises `StartError` if its secret cannot be read.

    `name` is its number in the configuration and its host: the URL's path may be a secret. Urgent
    events have a queue of their own and never wait for `news` or for a retry of them. A receiver
    that answers 410 is `gone`: nothing more is posted to it.
    """

    def __init__(self, number: int, settings: HookSettings, clock: Clock) -> None:
        self.name = f"{number} ({settings.host})"
        self.urgent, self.news = self.outboxes = (Outbox(URGENT_WAIT_S), Outbox())
        self.gone: Sentence | None = None
        self._refused_types: set[str] = set()
        self._settings = settings
        self._clock = clock
        self._secret = read_secret(settings.secret_file, f"hook[{number - 1}].secret_file")
        self._tls: ssl.SSLContext | bool = True
        if settings.ca_file:
            self._tls = client_tls(settings.ca_file, f"hook[{number - 1}].ca_file")

    def put(self, event: Event) -> None:
        """Enqueue an event if this hook subscribes to its type."""
        if not self._settings.events or event.type in self._settings.events:
            outbox = self.urgent if event.type.startswith(_URGENT) else self.news
            outbox.put(self.message(event))
            if self.gone is not None:
                outbox.drop_all()

    def message(self, event: Event) -> Message:
        """Return the message that carries an event."""
        told = event if self._settings.names else nameless(event)
        body = told.model_dump_json().encode()
        return Message(f"msg_{secrets.token_hex(16)}", event.type, body, self._clock.now_s())

    async def post(
        self, http: aiohttp.ClientSession, message: Message, *, wants_answer: bool = False
    ) -> tuple[int, bytes]:
        """Make one attempt; see `wax.hooks.post.post`."""
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
        """Post at most one due event of each queue; never raises."""
        await asyncio.gather(*(self._step(http, outbox) for outbox in self.outboxes))

    async def run(self, http: aiohttp.ClientSession) -> None:
        """Post until cancelled."""
        await asyncio.gather(*(self._run(http, outbox) for outbox in self.outboxes))

    async def flush(self, http: aiohttp.ClientSession) -> None:
        """Post each queue until it is empty or an attempt fails that could be retried."""
        await asyncio.gather(*(self._flush(http, outbox) for outbox in self.outboxes))

    async def _step(self, http: aiohttp.ClientSession, outbox: Outbox) -> None:
        message = outbox.due(self._clock.now_s())
        if message is not None:
            await self._attempt(http, outbox, message)

    async def _run(self, http: aiohttp.ClientSession, outbox: Outbox) -> None:
        while True:
            await self._step(http, outbox)
            await asyncio.sleep(_POLL_S)

    async def _flush(self, http: aiohttp.ClientSession, outbox: Outbox) -> None:
        while (message := outbox.first) is not None and await self._attempt(http, outbox, message):
            pass

    async def _attempt(self, http: aiohttp.ClientSession, outbox: Outbox, message: Message) -> bool:
        """Attempt one delivery; return whether the next may follow."""
        try:
            await self.post(http, message)
        except HookError as error:
            failure = error
        except Exception as error:  # driving does not depend on it
            failure = HookError(says(repr(error)))
        else:
            outbox.delivered(message)
            return True
        if failure.is_gone:
            self._disable(failure.sentence)
        elif failure.is_final:
            if message.type not in self._refused_types:
                self._refused_types.add(message.type)
                self._log("a hook refuses an event", failure.sentence, message)
            outbox.refuse(message, failure.sentence)
        else:
            if self.problem is None:  # logged once until a delivery succeeds: it may fail for days
                self._log("a hook did not take an event", failure.sentence, message)
            outbox.failed(failure.sentence, self._clock.now_s(), failure.wait_s)
        return failure.is_final

    def _disable(self, why: Sentence) -> None:
        """Post nothing more: the receiver has answered that it is gone."""
        if self.gone is None:
            _LOG.warning("a hook is off until the next start", hook=self.name, why=str(why))
        self.gone = why
        for outbox in self.outboxes:
            outbox.drop_all()

    def _log(self, what: str, why: Sentence, message: Message) -> None:
        _LOG.warning(what, hook=self.name, what=message.type, why=str(why))

    @property
    def waiting(self) -> int:
        return sum(map(len, self.outboxes))

    @property
    def lost(self) -> int:
        return sum(outbox.lost for outbox in self.outboxes)

    @property
    def refused(self) -> int:
        return sum(outbox.refused for outbox in self.outboxes)

    @property
    def problem(self) -> Sentence | None:
        """Why the receiver is gone or the newest attempt failed; None if neither."""
        return self.gone or self.urgent.problem or self.news.problem

    def status(self) -> dict[str, object]:
        """Return this hook's entry for the host's status page."""
        return {
            "name": self.name,
            "problem": None if self.problem is None else str(self.problem),
            "disabled": self.gone is not None,
            "waiting": self.waiting,
            "taken": sum(outbox.taken for outbox in self.outboxes),
            "refused": self.refused,
            "lost": self.lost,
        }

    def problems(self) -> Iterator[Sentence]:
        """Yield the problems to show to the host."""
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
    """All hooks of `[[hook]]`, idle if there are none. Raises `StartError`."""

    def __init__(
        self, settings: Sequence[HookSettings], clock: Clock, own_port: Callable[[], int]
    ) -> None:
        self._hooks = [Hook(number, one, clock) for number, one in enumerate(settings, 1)]
        self._own_port = own_port
        self._contained = FirstErrorLogged("events are lost")

    def put(self, event: Event) -> None:
        """Enqueue an event for each hook that subscribes to it; never raises."""
        with self._contained:
            for hook in self._hooks:
                hook.put(event)

    async def run(self) -> None:
        """Post until cancelled; no failure ends it, since driving does not depend on hooks."""
        if self._hooks:
            with self._contained:
                async with session(self._own_port) as http:
                    await asyncio.gather(*(hook.run(http) for hook in self._hooks))
        await asyncio.Event().wait()

    async def close(self) -> None:
        """Attempt to post the backlog, for at most a second; never raises."""
        if any(hook.waiting for hook in self._hooks):
            with self._contained, suppress(TimeoutError):
                async with asyncio.timeout(_FLUSH_S), session(self._own_port) as http:
                    await asyncio.gather(*(hook.flush(http) for hook in self._hooks))

    def status(self) -> list[dict[str, object]]:
        """Return an entry for each hook for the host's status page."""
        return [one.status() for one in self._hooks]

    def problems(self) -> list[Sentence]:
        """Return the problems to show to the host."""
        return [what for one in self._hooks for what in one.problems()]
