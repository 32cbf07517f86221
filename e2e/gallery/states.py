"""Every state of the page, and the words by which it is known: a renamed one is one edit here."""

from __future__ import annotations

import re
from typing import Final

from e2e.gallery import broken, driving, panels, watching
from e2e.gallery.state import State

_DRIVING: Final = re.compile("You are driving")


def _any(*words: str) -> re.Pattern[str]:
    return re.compile("|".join(words), re.IGNORECASE)


STATES: Final = (
    State(
        "connecting",
        "Connecting",
        watching.connecting,
        _any("connecting"),
        has_stop=False,
    ),
    State("first-visit", "A first visit", watching.first_visit, _any("welcome", "first time")),
    State("free", "Watching, the robot is free", watching.free, _any("robot is free")),
    State(
        "somebody-drives",
        "Watching, somebody drives",
        watching.somebody_drives,
        _any("Ada is driving", "Ada drives"),
    ),
    State("waiting", "Waiting", watching.waiting, _any("number 2", "2nd in")),
    State("next", "You are next", watching.you_are_next, _any("you are next")),
    State("called", "Called: are you ready?", watching.called, _any("are you ready")),
    State("driving", "Driving", driving.driving, _DRIVING),
    State("slow", "Driving slowly: the picture is late", driving.slow, _any("picture is late")),
    State(
        "paused",
        "Paused: the picture stands still",
        driving.paused,
        _any("no fresh picture", "waits until you can see"),
    ),
    State(
        "stopped-by-you",
        "Stopped, by you",
        driving.stopped_by_you,
        _any("stopped by", "you stopped", "you have stopped"),
    ),
    State(
        "stopped-by-another",
        "Stopped, by another",
        driving.stopped_by_another,
        _any("stopped by wanda", "wanda has? ?stopped"),
    ),
    State(
        "stopped-by-host",
        "Stopped, by the host",
        driving.stopped_by_host,
        _any("stopped by the host", "stopped by host", "host has stopped"),
    ),
    State(
        "stopped-watched",
        "Stopped, seen by who watches",
        driving.stopped_watched,
        _any("stopped by ada", "ada has? ?stopped"),
    ),
    State("turn-over", "Your turn is over", watching.turn_over, _any("thank")),
    State(
        "robot-lost",
        "The robot does not answer",
        broken.robot_lost,
        _any("robot: ", "the robot does not answer", "robot is lost"),
    ),
    State(
        "camera-failed",
        "The camera fails",
        broken.camera_failed,
        _any("camera delivers no picture"),
    ),
    State(
        "picture-frozen",
        "The picture stands still",
        broken.picture_frozen,
        _any("picture is .* old", "stands still", "frozen"),
    ),
    State("no-answer", "No answer for a moment", broken.no_answer, _any("no answer", "answering")),
    State("reconnecting", "Reconnecting", broken.reconnecting, _any("reconnecting")),
    State(
        "server-gone",
        "The server is gone",
        broken.server_gone,
        _any("reconnecting", "connection lost", "not connected"),
    ),
    State(
        "removed",
        "Removed by the host",
        watching.removed,
        _any("asked you to leave"),
        has_stop=False,
    ),
    State("closed", "Closed for today", watching.closed, _any("is closed"), has_stop=False),
    State(
        "full",
        "No place",
        watching.full,
        _any("only place is taken"),
        has_stop=False,
    ),
    State("picture-off", "The picture is off", panels.picture_off, _any("picture is off")),
    State("blanked", "Switched off by the host", panels.blanked, _any("host has switched")),
    State("console", "The host's console", panels.console, _any("door and privacy")),
    State("people", "Who is here", panels.people, _any("your name")),
    State("settings", "The settings", panels.settings, _any("picture size")),
    State("details", "The details", panels.details, _any("picture age")),
    State("rules", "What happens if something fails", panels.rules, _any("no page can change")),
    State(
        "big-screen",
        "On a big screen (?view=big-screen)",
        watching.big_screen,
        _any("scan to drive"),
        shows=lambda page: page.get_by_role("img", name=re.compile("^QR code")),
        has_stop=False,
    ),
)


def named(key: str) -> State:
    """Return the state with this key; raises `StopIteration`."""
    return next(state for state in STATES if state.key == key)
