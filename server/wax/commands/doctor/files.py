"""Checks the configured files that no other check reads: secrets, keys, the page's picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.clock import SystemClock
from wax.commands.doctor.verdict import Verdict, ok
from wax.robot.find_driver import make_driver
from wax.rtc.ice_servers import IceServers
from wax.speaker.find_speaker import make_speaker
from wax.web import preview_picture

if TYPE_CHECKING:
    from wax.config.settings import Settings


def files(settings: Settings) -> Verdict:
    """Read them as the server does at its start, without connecting; raises `WaxError`."""
    clock = SystemClock()
    make_speaker(settings.voice, clock, make_driver(settings.robot, clock))
    preview_picture.read(settings.page.picture)
    IceServers(settings.network, settings.relay)
    for room in settings.publish:
        room.secret()
    return ok("All other files that the configuration names can be read.")
