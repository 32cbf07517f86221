"""The tunnel's ssh command, and what ssh's messages mean. Pure.

OpenSSH prints no error codes, so its English is parsed; an unknown message is passed on.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, Literal

from wax.logs.printable import printable
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from pathlib import Path

    from wax.config.door import DoorSettings

Way = Literal["ssh", "https"]

USER: Final = "wax-door"
ALIAS: Final = "wax-door"
"""The name of the pinned key, the same whatever name or address the door has."""
CONNECT_S: Final = 4
ALIVE_S: Final = 2
ALIVE_COUNT: Final = 3
"""The unanswered keepalives that end ssh: a stalled tunnel is noticed after 8 s."""
OPENED: Final = "debug1: remote forward success for"
"""The start of the line by which `ssh -v` says that the tunnel is open. The rest of a line may
quote a machine whose key has not been checked yet."""
_MOST_CHARS: Final = 200

_OPTIONS: Final = (
    *("BatchMode=yes", "PasswordAuthentication=no", "KbdInteractiveAuthentication=no"),
    *("IdentitiesOnly=yes", "IdentityAgent=none", "StrictHostKeyChecking=yes"),
    *("GlobalKnownHostsFile=/dev/null", "UpdateHostKeys=no", "HostKeyAlgorithms=ssh-ed25519"),
    *(f"HostKeyAlias={ALIAS}", "CheckHostIP=no", "ExitOnForwardFailure=yes", "LogLevel=DEBUG1"),
    *(f"ConnectTimeout={CONNECT_S}", f"ServerAliveInterval={ALIVE_S}"),
    *(f"ServerAliveCountMax={ALIVE_COUNT}", "TCPKeepAlive=no", "IPQoS=af21"),
)

_MEANS: Final = tuple(
    (re.compile(pattern, re.IGNORECASE), code)
    for pattern, code in (
        (r"no user exists for uid", "no_user"),
        (r"identification has changed|host key verification failed", "host_key"),
        (r"no ed25519 host key|no matching host key type", "host_key"),
        (r"could not resolve|not known|no address associated", "name"),
        (r"no such identity|load key|unprotected private key", "key_file"),
        (r"permission denied \(", "key"),
        (r"remote port forwarding failed", "taken"),
        (r"not responding|broken pipe|timed out during banner", "stalled"),
        (r"no upgrade:", "no_https"),
        (r"connection refused|timed out|no route|unreachable", "closed"),
        (r"connection (closed|reset)|closed by remote|kex_exchange", "ended"),
    )
)
"""The first match counts: a key that cannot be read is refused as well."""


def command(door: DoorSettings, way: Way, known_hosts: Path, target: str, proxy: str) -> list[str]:
    """Return the command that forwards the door's port to `target`, ``HOST:PORT`` seen from here.

    `proxy` is the ProxyCommand of the way by HTTPS.
    """
    options = [
        *_OPTIONS,
        f"UserKnownHostsFile={_quoted(str(known_hosts))}",
        # Not -i: without such a file, ssh would ignore it and try the user's own keys.
        f"IdentityFile={_quoted(door.key_file)}",
    ]
    if way == "https":
        options.append(f"ProxyCommand={proxy}")
    return [
        *("ssh", "-F", "none", "-N", "-T", "-a", "-x", "-p", "22"),
        *(word for option in options for word in ("-o", option)),
        *("-R", f"127.0.0.1:{door.port}:{target}", f"{USER}@{door.host}"),
    ]


def known_hosts(door: DoorSettings) -> str:
    """Return the contents of a known_hosts file with only the pinned key."""
    return f"{ALIAS} {door.host_key}\n"


def problem(door: DoorSettings, said: list[str]) -> Sentence:
    """Return why ssh ended, from its last lines."""
    lines = [line.strip() for line in said if line.strip() and not line.startswith("debug1:")]
    text = "\n".join(lines)
    kind = next((kind for pattern, kind in _MEANS if pattern.search(text)), None)
    if kind is None:
        why = says(printable(lines[-1].rstrip("."), _MOST_CHARS) if lines else "ssh ended")
        return Sentence("tunnel.failed", {"host": door.host, "why": why})
    if kind == "no_user":
        return Sentence("tunnel.no_user")
    if kind == "key_file":
        return Sentence("tunnel.key_file", {"file": door.key_file})
    if kind == "taken":
        return Sentence("tunnel.taken", {"host": door.host, "port": str(door.port)})
    return Sentence(
        {
            "host_key": "tunnel.host_key",
            "name": "tunnel.name",
            "key": "tunnel.key",
            "stalled": "tunnel.stalled",
            "no_https": "tunnel.no_https",
            "closed": "tunnel.closed",
            "ended": "tunnel.ended",
        }[kind],
        {"host": door.host},
    )


def _quoted(path: str) -> str:
    """Return a path quoted for an option of ssh, where % begins a token and a space ends a word."""
    return '"' + path.replace("%", "%%") + '"'
