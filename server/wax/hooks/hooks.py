"""All hooks: each posts what it wants to know, one at a time; whatever fails here stays here."""

from __future__ import annotations

import asyncio
import secrets
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import structlog

from wax.error_boundary import FirstErrorLogged
from wax.hooks.outbox import Message, Outbox
from wax.hooks.post import HookError, post, session
from wax.hooks.signature import read_secret
from wax.protocol.events import nameless
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import aiohttp

    from wax.clock import Clock
    from wax.config.hook import HookSettings
    from wax.protocol.events import Event

_LOG = structlog.get_logger(__name__)

_LOOK_S: Final = 0.1
"""So often at most each hook posts: a hundred that waited are no burst."""
_LAST_S: Final = 1.0
"""The end of the server waits no longer for the last events."""


class Hook:
    """One receiver; raises `StartError` if its secret cannot be read.

    `name` is its number in the configuration and its host: its path is nobody's business.
    """

    def __init__(self, number: int, settings: HookSettings, clock: Clock) -> None:
        self.name = f"{number} ({settings.host})"
        self.outbox = Outbox()
        self._settings = settings
        self._clock = clock
        self._secret = read_secret(settings.secret_file, f"hook[{number - 1}].secret_file")

    def put(self, event: Event) -> None:
        """Have an event posted soon, if this hook asks for it."""
        if not self._settings.events or event.type in self._settings.events:
            self.outbox.put(self.message(event))

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
            wants_answer=wants_answer,
        )

    async def step(self, http: aiohttp.ClientSession) -> None:
        """Post what is due, if anything is; never raises."""
        message = self.outbox.due(self._clock.now_s())
        if message is not None:
            await self._try(http, message)

    async def run(self, http: aiohttp.ClientSession) -> None:
        """Post until cancelled."""
        while True:
            await self.step(http)
            await asyncio.sleep(_LOOK_S)

    async def empty(self, http: aiohttp.ClientSession) -> None:
        """Post all that waits, up to the first that is in vain."""
        while (message := self.outbox.first) is not None and await self._try(http, message):
            pass

    async def _try(self, http: aiohttp.ClientSession, message: Message) -> bool:
        try:
            await self.post(http, message)
        except HookError as error:
            why = error.sentence
        except Exception as error:  # driving does not need it
            why = says(repr(error))
        else:
            self.outbox.took(message)
            return True
        self.outbox.failed(why, self._clock.now_s())
        _LOG.warning(
            "a hook did not take an event",
            hook=self.name,
            what=message.type,
            why=str(why),
            waiting=len(self.outbox),
            lost=self.outbox.lost,
        )
        return False


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
        if any(hook.outbox.first for hook in self._hooks):
            with self._contained, suppress(TimeoutError):
                async with asyncio.timeout(_LAST_S), session(self._own_port) as http:
                    await asyncio.gather(*(hook.empty(http) for hook in self._hooks))

    def status(self) -> list[dict[str, object]]:
        """Return each hook as the host's status page has it."""
        return [
            {
                "name": one.name,
                "problem": None if one.outbox.problem is None else str(one.outbox.problem),
                "waiting": len(one.outbox),
                "taken": one.outbox.taken,
                "lost": one.outbox.lost,
            }
            for one in self._hooks
        ]

    def problems(self) -> list[Sentence]:
        """Return what the host is to know."""
        told = []
        for one in self._hooks:
            box = one.outbox
            if box.problem is not None and len(box):
                told.append(
                    Sentence("hook.waiting", {"hook": one.name, "n": len(box), "why": box.problem})
                )
            if box.lost:
                told.append(Sentence("hook.lost", {"hook": one.name, "n": box.lost}))
        return told
