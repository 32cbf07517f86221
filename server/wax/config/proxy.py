"""`[access.proxy]`: a proxy in front that knows who people are."""

from __future__ import annotations

import ipaddress
import re
from typing import TYPE_CHECKING, Annotated, Final, Self

from pydantic import Field, model_validator

from wax.config.allowed import printable, said
from wax.config.table import ConfigTable

if TYPE_CHECKING:
    from wax.config.server import ServerSettings

Header = Annotated[
    str,
    Field(pattern=r"^([A-Za-z][A-Za-z0-9-]{0,63})?$"),
    said('empty, or a header\'s name, as "Remote-User"'),
]
HeaderOrClaim = Annotated[str, printable(0, 100, "a header's or a claim's name")]
Group = Annotated[
    str,
    Field(pattern=r"^[^\x00-\x1f\x7f,|]{1,100}$"),
    said("a group's name of at most 100 printable characters, without , and |", plural="groups"),
]

_HEADER: Final = re.compile(r"([A-Za-z][A-Za-z0-9-]{0,63})?")
_EVERY_WAY: Final = "everybody could say who they are"


class ProxySettings(ConfigTable):
    """People by name, where a proxy in front of this server has signed them in (Authelia,
    oauth2-proxy, Authentik, Tailscale Serve): it says in a header who asks, and nobody else comes
    in. Only those in server.trusted_proxies are believed, each of which must replace what a visitor
    sends in these headers. A ban, the limit of Stop, and the shares and the place in the queue are
    the person's then, on whatever device. Whoever is signed out there is sent away here within a
    minute. Recipes are in config/deploy/README.md.
    """

    person: HeaderOrClaim = ""
    """The header with the person's user name, or another lasting identifier, as "Remote-User".
    Empty: this table is not used."""
    name: HeaderOrClaim = ""
    """The header with the name that is shown here, as "Remote-Name"; the name that somebody gives
    themselves on the page does not count then. Empty: people give themselves a name."""
    groups: HeaderOrClaim = ""
    """The header with the person's groups, as "Remote-Groups", separated by commas or "|"."""
    host: list[Group] = []
    """The groups whose people are host."""
    drive: list[Group] = []
    """The groups whose people may queue and drive, as with an invitation."""
    watch: list[Group] = []
    """The groups whose people may watch, and no more. People in no group named here are strangers
    ([access]) while `drive` and `watch` are empty, and otherwise refused."""
    refuse: list[Group] = []
    """The groups whose people are refused, whatever other groups they are in."""
    host_link: bool = True
    """Whether a host link makes somebody host, too, even past the proxy. It can be switched off
    only where `host` has groups."""
    one_place: bool = True
    """Whether a person has one place in the queue, on all devices together. If not, each browser
    has one, as for an account that a class shares."""
    token: Header = ""
    """The header with a token that the proxy signs (a JWT by RS256 or ES256), such as
    "Cf-Access-Jwt-Assertion" or "X-Goog-Iap-Jwt-Assertion". Then person, name and groups are
    claims in it, as "email", and its signature is believed, not the proxy. Empty: none."""
    keys: Annotated[
        str,
        Field(pattern=r"^(https://[^\s/?#@:\[\]]+(:\d{1,5})?(/[^\s#]*)?|[^:\x00]*)$"),
        said('a file, or an address as "https://example.org/certs"'),
    ] = ""
    """The public keys of that token (JWKS): a file, or the address where they are published. They
    are read again every hour, and when a token names another."""
    issuer: str = ""
    """Who makes the token, as its claim "iss" has it."""
    audience: str = ""
    """For whom the token is made, as its claim "aud" has it."""

    @property
    def is_used(self) -> bool:
        return bool(self.person)

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        signing = ("keys", "issuer", "audience")
        missing = [name for name in signing if bool(getattr(self, name)) != bool(self.token)]
        if missing:
            what = f"{' and '.join(missing)} missing" if self.token else "token is missing"
            raise ValueError(f"{what}: token, keys, issuer and audience belong together")
        if not self.token:
            for key in ("person", "name", "groups"):
                if not _HEADER.fullmatch(text := getattr(self, key)):
                    raise ValueError(
                        f'{key} is {text!r}, which is no header\'s name as "Remote-User"'
                    )
        if not self.person and (self.name or self.groups or self.token):
            raise ValueError("person is missing: name what says who asks")
        if (self.host or self.drive or self.watch or self.refuse) and not self.groups:
            raise ValueError("groups is missing: name what has the person's groups")
        if not (self.host_link or self.host):
            raise ValueError("host_link is off, so nobody could be host; name a group in host")
        return self


def check_believed(proxy: ProxySettings, server: ServerSettings, door: str) -> None:
    """Raise `ValueError` if strangers would be believed when they say who they are."""
    if not proxy.is_used:
        return
    if not server.trusted_proxies:
        raise ValueError(
            "access.proxy: no proxy is trusted, so nobody could come in; name its address in"
            ' [server] trusted_proxies, as ["127.0.0.1", "::1"]'
        )
    if proxy.token:
        return  # by whatever way it comes, its signature counts
    if door:
        raise ValueError(
            f"access.proxy: the door hands on what strangers write, so {_EVERY_WAY}; leave [door]"
            " or [access.proxy] out, or name a signed token"
        )
    for text in server.trusted_proxies:
        network = ipaddress.ip_network(text, strict=False)
        if network.num_addresses > 1 and not network.is_private:
            raise ValueError(
                f"access.proxy: server.trusted_proxies has {text}, where strangers are, too, so"
                f" {_EVERY_WAY}; name the proxy's own address"
            )


def doubts(proxy: ProxySettings, server: ServerSettings) -> list[tuple[str, str]]:
    """Return by what more people may be believed, or refused, than was meant, and what to do."""
    if not proxy.is_used or proxy.token:
        return []
    told = []
    for text in server.trusted_proxies:
        network = ipaddress.ip_network(text, strict=False)
        if network.num_addresses > 1 and not network.is_loopback:
            told.append(
                (
                    f"Every machine in {text} is believed when it says who somebody is.",
                    "Name the proxy's own address in [server] trusted_proxies.",
                )
            )
    if server.host in ("0.0.0.0", "::"):
        told.append(
            (
                "Whoever comes past the proxy reaches this server, though only to be refused.",
                'If the proxy is on this machine, set [server] host = "localhost".',
            )
        )
    return told
