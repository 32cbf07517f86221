"""Checks `[door]`: each step of the path by which people elsewhere reach the page."""

from __future__ import annotations

import socket
import tempfile
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax.commands.doctor.verdict import Check, Verdict, bad, ok, warning
from wax.door import ssh
from wax.door.page import check_page
from wax.door.tunnel import command, lines_of, start, target, with_key
from wax.rtc import relay_check
from wax.rtc.ice_servers import IceServers
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.config.door import DoorSettings
    from wax.config.settings import Settings
    from wax.door.ssh import Way

_TRY_S: Final = 12.0
_ADVICE: Final = "config/deploy/README.md, “Through a door”, has each step."


def checks(settings: Settings, wall_s: float, *, running: bool) -> list[Check]:
    """Return the checks of the door; empty without one."""
    door = settings.door
    if not door.host:
        return []
    return [
        Check("door's name", lambda: name(door)),
        Check("door's tunnel", lambda: tunnel(door, running=running), 2 * _TRY_S + 2),
        Check("door's page", lambda: page(settings, wall_s, running=running), 12.0),
        Check("door's relay", lambda: relay(settings, wall_s), 30.0),
    ]


def name(door: DoorSettings) -> Verdict:
    """Resolve the door's host name."""
    try:
        found = socket.getaddrinfo(door.host, 22, type=socket.SOCK_STREAM)
    except OSError:
        return bad(str(Sentence("tunnel.name", {"host": door.host})), _ADVICE)
    return ok(f"{door.host} is {', '.join(sorted({str(one[4][0]) for one in found}))}.")


def tunnel(
    door: DoorSettings,
    *,
    running: bool,
    attempt: Callable[[DoorSettings, Way], Sentence | None] | None = None,
) -> Verdict:
    """Open the tunnel as the server does, by both ways, and close it at once."""
    attempt = attempt or _attempt
    ways: tuple[Way, ...] = ("ssh", "https")
    problems = {way: attempt(door, way) for way in ways}
    found = {way: None if one is None else one.code for way, one in problems.items()}
    if running:  # the port is the server's, as it should be: only the key counts
        found = {way: None if code == "tunnel.taken" else code for way, code in found.items()}
    told = "has the pinned key, and lets its port lead here"
    if found["ssh"] is found["https"] is None:
        return ok(f"The door {told}.")
    if None in found.values():
        [(way, problem)] = [(way, one) for way, one in problems.items() if found[way] is not None]
        port = 22 if way == "ssh" else 443
        return warning(f"The door {told}, but not by TCP {port}: {problem}", _ADVICE)
    return bad(str(problems["ssh"]), _ADVICE)


def page(settings: Settings, wall_s: float, *, running: bool) -> Verdict:
    """Open the page at its public address."""
    url = settings.server.public_url
    if not url:
        return bad("The page's public address is not known.", "Set [server] public_url.")
    here = target(settings.server.host, settings.server.port) if running else None
    problem = check_page(url, wall_s, here)
    if problem is None:
        return ok(f"{url} opens, with a valid certificate.")
    if problem.code == "tunnel.page" and not running and "502" in str(problem):
        return ok(f"{url} has a valid certificate; the page opens once the server runs.")
    return bad(str(problem), _ADVICE)


def relay(settings: Settings, wall_s: float) -> Verdict:
    """Relay a packet each way by each of the relay's addresses."""
    servers = IceServers(settings.network, settings.relay).for_viewer("doctor", wall_s)
    found = [one for one in servers if "credential" in one]
    if not found:
        return warning(
            "There is no relay: who has no direct way to the robot sees nothing.", "See [relay]."
        )
    [one] = found
    problems = {
        url: relay_check.problem(url, one["username"], one["credential"]) for url in one["urls"]
    }
    failed = [f"{url} ({why})" for url, why in problems.items() if why is not None]
    if not failed:
        return ok(f"The relay carries by {', '.join(problems)}.")
    told = f"The relay does not carry by {', '.join(failed)}."
    advice = "Let these ports in at the door; right after its setup TLS takes a minute."
    return bad(told, advice) if len(failed) == len(problems) else warning(told, advice)


def _attempt(door: DoorSettings, way: Way) -> Sentence | None:
    """Return why the tunnel cannot be opened this way, None if it can."""
    try:
        door = with_key(door)
    except OSError:
        return Sentence("tunnel.key_file", {"file": door.key_file})
    with tempfile.TemporaryDirectory() as folder:
        try:
            child = start(command(door, way, Path(folder), "127.0.0.1:9"))
        except FileNotFoundError:
            return Sentence("tunnel.no_ssh")
        assert child.stderr is not None
        ends = threading.Timer(_TRY_S, child.terminate)
        ends.start()
        said = []
        try:
            for line in lines_of(child.stderr):
                said.append(line)
                if line.startswith(ssh.OPENED):
                    return None
        finally:
            ends.cancel()
            child.terminate()
            child.wait()
            child.stderr.close()
    return ssh.problem(door, said)
