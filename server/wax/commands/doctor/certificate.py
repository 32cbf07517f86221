"""Checks the certificate: that it exists, covers the names, is valid, and has its key."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING, Final

from wax.commands.doctor.verdict import Verdict, bad, ok, warning
from wax.errors import StartError, reason_of
from wax.named_file import read_bytes

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from wax.commands.doctor.network import ServedNetwork
    from wax.web.certificate import Certificate

SOON: Final = datetime.timedelta(days=14)
"""Services that issue certificates renew a month before the end: two weeks is late."""
_RENEW: Final = "Renew it; a running server takes the new one by itself."
_RENEWS: Final = "Start the server, which renews it."


def certificate(network: ServedNetwork, now: datetime.datetime) -> Verdict:
    """Check the configured pair, or the server's own; `now` has a time zone."""
    if network.certificate is None:
        return _without(network)
    if not network.is_self_signed:
        return _checked(network.certificate, network.names, now)
    if not network.certificate.chain.exists():
        return ok("The server makes a certificate of its own at its first start.")
    # The server renews it with its names.
    verdict = _checked(network.certificate, (), now, _RENEWS)
    if verdict.level != "ok":
        return verdict
    return warning(
        f"{verdict.sentence} It is self-signed: every browser warns of it.",
        "In the local network, compare its fingerprint; for the world get one from a public"
        " authority, by a proxy such as Caddy.",
    )


def _without(network: ServedNetwork) -> Verdict:
    if network.is_self_signed:
        return bad("Nothing says where to keep a certificate.", "Set [server] state_dir.")
    if network.is_behind_proxy:
        return ok(
            "The proxy in front has the certificate; `wax doctor --reach URL` looks at it from"
            " elsewhere."
        )
    if network.is_local:
        return ok("The page is served by plain HTTP, on this machine only.")
    return warning(
        "The page is served by plain HTTP: browsers then lack gamepads, and anybody on the way"
        " can read and change it.",
        "Configure a certificate, use --https, or put a proxy with HTTPS in front.",
    )


def _checked(
    pair: Certificate, wanted: Sequence[str], now: datetime.datetime, renew: str = _RENEW
) -> Verdict:
    """Check a certificate and its key, for the names that it must cover."""
    for path in (pair.chain, pair.key):
        if (problem := _unreadable(path)) is not None:
            return bad(problem, "Check server.certificate and server.key and who may read them.")
    try:
        pair.context()
        begins, ends = pair.validity()
        names = sorted(pair.names())
    except StartError as error:
        sentence = str(error)
        return bad(
            f"{sentence[:1].upper()}{sentence[1:]}.",
            "Configure the full chain and the key that belongs to it.",
        )
    return _valid(names, (begins, ends), wanted, now, renew)


def _valid(
    names: Sequence[str],
    validity: tuple[datetime.datetime, datetime.datetime],
    wanted: Sequence[str],
    now: datetime.datetime,
    renew: str,
) -> Verdict:
    begins, ends = validity
    if now < begins:
        return bad(f"The certificate is valid from {begins:%Y-%m-%d} on.", "Check the clock.")
    if now >= ends:
        return bad(f"The certificate ended on {ends:%Y-%m-%d}.", renew)
    missing = [name for name in wanted if not any(_covers(one, name) for one in names)]
    if missing:
        return bad(
            f"The certificate is for {', '.join(names) or 'no name'}, not for"
            f" {', '.join(missing)}.",
            "Get one for all server.names.",
        )
    if ends - now < SOON:
        return warning(f"The certificate ends on {ends:%Y-%m-%d}, soon.", renew)
    return ok(f"The certificate for {', '.join(names)} is valid until {ends:%Y-%m-%d}.")


def _covers(pattern: str, name: str) -> bool:
    """Compare as browsers do: a star matches exactly one label, the first (RFC 9525, 6.3)."""
    pattern, name = pattern.lower(), name.lower().rstrip(".")
    if pattern.startswith("*."):
        return name.partition(".")[2] == pattern[2:]
    return pattern == name


def _unreadable(path: Path) -> str | None:
    try:
        read_bytes(path)
    except OSError as error:
        return f"The file {path} cannot be read: {reason_of(error)}."
    return None
