"""The suite's operator: the protocol's client, at full speed, who remembers what stopped them."""

from __future__ import annotations

import time
import uuid
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import aiohttp

from wax.client import Operator
from wax.rtc import private

if TYPE_CHECKING:
    from e2e.harness.server import Server


@dataclass(frozen=True, slots=True)
class Browser:
    """The identity that the server recognises after a reconnection, and one of its tabs."""

    cookies: aiohttp.CookieJar = field(default_factory=partial(aiohttp.CookieJar, unsafe=True))
    tab: str = field(default_factory=lambda: str(uuid.uuid4()))


class RawOperator(Operator):
    """`browser` is its identity, by default a new one; `options` are those of `Operator`."""

    def __init__(self, server: Server, *, browser: Browser | None = None, **options: Any) -> None:
        private.install()  # a browser also stays on a slow link, which aioice by itself leaves
        who = browser or Browser()
        super().__init__(
            server.url, client_id=who.tab, cookies=who.cookies, on_message=self._told, **options
        )
        self.reasons: list[tuple[float, str]] = []
        """When the page was told that the robot stands, or is slower, and why."""

    def _told(self, message: dict[str, Any]) -> None:
        if message["type"] == "drive_status" and message["reason"] is not None:
            self.reasons.append((time.monotonic(), message["reason"]["code"]))
