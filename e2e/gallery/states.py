"""Every state of the page, how it comes about, and the words that identify it."""

from __future__ import annotations

import re
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.gallery import broken, driving, panels, watching
from e2e.gallery.scene import Scene, scene

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from playwright.async_api import Browser, Locator, Page

    from e2e.gallery.views import Device

_SAYS_WITHIN_MS: Final = 30_000.0


@dataclass(frozen=True, slots=True)
class State:
    """`tell` brings it about, by what a person or the world does, never by the page's internals.

    The state is reached when the page `says` these words, in any case, or when `shows` finds it.
    `has_stop`: the Stop button belongs to this state.
    """

    key: str
    title: str
    tell: Callable[[Scene], Awaitable[object]]
    says: str | re.Pattern[str]
    shows: Callable[[Page], Locator] | None = None
    has_stop: bool = True

    def mark(self, page: Page) -> Locator:
        if self.shows is not None:
            return self.shows(page)
        return page.get_by_text(self.says).locator("visible=true").first

    @asynccontextmanager
    async def reached(self, browser: Browser, device: Device) -> AsyncIterator[Scene]:
        """Yield the page in this state; raises `AssertionError` or Playwright's `Error`."""
        async with scene(browser, device) as stage:
            await self.tell(stage)
            await self.mark(stage.viewer.page).wait_for(state="visible", timeout=_SAYS_WITHIN_MS)
            yield stage


STATES: Final = (
    State("connecting", "Connecting", watching.connecting, "connecting", has_stop=False),
    State("first-visit", "A first visit", partial(Scene.opens, is_new=True), "welcome"),
    State("free", "Watching, the robot is free", Scene.opens, "robot is free"),
    State(
        "somebody-drives", "Watching, somebody drives", watching.somebody_drives, "Ada is driving"
    ),
    State("waiting", "Waiting", watching.waiting, "number 2"),
    State("next", "You are next", watching.you_are_next, "you are next"),
    State("called", "Called: are you ready?", watching.called, "are you ready"),
    State("driving", "Driving", driving.driving, "You are driving"),
    State("sideways", "Driving, sideways too", driving.sideways, "You are driving"),
    State("slow", "Driving slowly: the picture is late", driving.slow, "picture is late"),
    State("paused", "Paused: the picture stands still", driving.paused, "no fresh picture"),
    State("stopped-by-you", "Stopped, by you", driving.stopped_by_you, "you stopped the robot"),
    State(
        "stopped-by-another", "Stopped, by another", driving.stopped_by_another, "stopped by wanda"
    ),
    State("stopped-by-host", "Stopped, by the host", driving.stopped_by_host, "stopped by host"),
    State(
        "stopped-watched", "Stopped, seen by who watches", driving.stopped_watched, "stopped by ada"
    ),
    State("turn-over", "Your turn is over", watching.turn_over, "thanks for driving"),
    State("robot-lost", "The robot does not answer", broken.robot_lost, "robot: "),
    State("camera-failed", "The camera fails", broken.camera_failed, "delivers no picture"),
    State(
        "picture-frozen",
        "The picture stands still",
        broken.picture_frozen,
        re.compile("picture is .* old"),
    ),
    State("no-answer", "No answer for a moment", broken.no_answer, "no answer"),
    State("reconnecting", "Reconnecting", broken.reconnecting, "reconnecting"),
    State("server-gone", "The server is gone", broken.server_gone, "reconnecting"),
    State("removed", "Removed by the host", watching.removed, "asked you to leave", has_stop=False),
    State("closed", "Closed, and when it opens", watching.closed, "is closed", has_stop=False),
    State("full", "No place", watching.full, "only place is taken", has_stop=False),
    State("picture-off", "The picture is off", panels.picture_off, "picture is off"),
    State("blanked", "Switched off by the host", panels.blanked, "host has switched"),
    State("console", "The host's console", panels.console, "door and privacy"),
    State("people", "Who is here", panels.people, "your name"),
    State("settings", "The settings", panels.settings, "picture size"),
    State("details", "The details", panels.details, "picture age"),
    State("rules", "What happens if something fails", panels.rules, "no page can change"),
    State(
        "big-screen",
        "On a big screen (?view=big-screen)",
        watching.big_screen,
        "scan to drive",
        shows=lambda page: page.get_by_role("img", name=re.compile("^QR code")),
        has_stop=False,
    ),
    State(
        "embed",
        "In a frame on another site (?view=embed)",
        watching.embed,
        "1 person waits",
        has_stop=False,
    ),
    State(
        "glass",
        "Measuring the delay with camera and screen (?view=glass)",
        watching.glass,
        "camera to screen",
        has_stop=False,
    ),
)


def named(key: str) -> State:
    """Return the state with this key; raises `StopIteration`."""
    return next(state for state in STATES if state.key == key)
