"""Who somebody is by the word of a trusted proxy, and what their groups allow. Pure.

Each request is judged anew, by its own headers: a proxy sends the requests of many people over one
connection. What is not clear is not believed.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from email.errors import MessageError
from email.header import decode_header, make_header
from typing import TYPE_CHECKING, Any, Final, Literal

from wax.errors import NotAdmittedError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from wax.config.proxy import ProxySettings

Right = Literal["host", "drive", "watch", "stranger"]
"""What somebody's groups allow; a stranger may do what `[access]` says."""

PROOF_S: Final = 55.0
"""How long one request proves that its sender is still signed in; with the second until it is seen
that no other has come, and the time to close, it is a minute."""
_MOST_CHARS: Final = 256
_MOST_CHARS_OF_LISTS: Final = 4096

NOT_SIGNED_IN: Final = Sentence("door.not_signed_in")
_UNCLEAR: Final = Sentence("door.unclear_sign_in")
_NOT_FOR_THEM: Final = Sentence("door.not_for_group")


@dataclass(frozen=True, slots=True)
class Vouched:
    """Somebody of whom the proxy says who they are, until `until_s`; `refusal` if they may not in.

    `identity` is a hash, so that nobody's name is stored with a ban; `name` is to be shown, empty
    if they choose it themselves.
    """

    identity: str = ""
    name: str = ""
    right: Right = "stranger"
    refusal: Sentence | None = NOT_SIGNED_IN
    until_s: float = 0.0

    def at(self, now_s: float) -> Vouched:
        """Return the same, with nothing but the identity once the proof is too old."""
        return self if now_s < self.until_s or self.refusal else Vouched(self.identity)


class Vouching:
    """Judges by `[access.proxy]`; `names` are the headers that it reads, in lower case.

    `claims` returns what a signed token says; raises `ValueError` for one that is not valid, and
    `NotAdmittedError` if that cannot be known.
    """

    def __init__(
        self, settings: ProxySettings, claims: Callable[[str], Mapping[str, Any]] = lambda _: {}
    ) -> None:
        self._settings = settings
        self._claims = claims
        by_headers = settings.person, settings.name, settings.groups
        headers = [settings.token] if settings.token else by_headers
        self.names = frozenset(name.lower() for name in headers if name)

    def judge(self, said: Mapping[str, Sequence[str]], now_s: float) -> Vouched:
        """Return who a request's sender is; `said` has a trusted proxy's headers, by `names`.

        It must be empty for a request from anybody else.
        """
        try:
            person, name, groups = self._told(said)
            if person:
                _check_person(person)
        except ValueError:
            return Vouched(refusal=_UNCLEAR)
        except NotAdmittedError as error:
            return Vouched(refusal=error.sentence)
        if not person:
            return Vouched()
        right = self._right(groups)
        identity = f"person {hashlib.sha256(person.encode()).hexdigest()}"
        vouched = Vouched(identity, _decoded(name), until_s=now_s + PROOF_S)
        if right is None:
            return replace(vouched, refusal=_NOT_FOR_THEM)
        return replace(vouched, right=right, refusal=None)

    def _told(self, said: Mapping[str, Sequence[str]]) -> tuple[str, str, frozenset[str]]:
        """Return the person, their name and their groups, each empty if nothing says it."""
        settings = self._settings
        names = (settings.person, settings.name, settings.groups)
        if not settings.token:
            person, name, listed = [_only(said.get(one.lower(), ())) for one in names]
            return person, name, _listed(listed)
        token = _only(said.get(settings.token.lower(), ()))
        claims = self._claims(token) if token else {}
        person, name = (_text(claims.get(one, "")) for one in names[:2])
        groups = claims.get(settings.groups, "")
        if isinstance(groups, list):
            return person, name, frozenset(one for one in groups if isinstance(one, str))
        return person, name, _listed(_text(groups))

    def _right(self, groups: frozenset[str]) -> Right | None:
        """Return the most that these groups allow; None if they are refused."""
        settings = self._settings
        if not groups.isdisjoint(settings.refuse):
            return None
        if not groups.isdisjoint(settings.host):
            return "host"
        if not groups.isdisjoint(settings.drive):
            return "drive"
        if not groups.isdisjoint(settings.watch):
            return "watch"
        return None if settings.drive or settings.watch else "stranger"


def _only(values: Sequence[str]) -> str:
    """Return a header's value, empty if there is none; raises `ValueError` if there are several.

    A proxy that adds its own beside a visitor's would let the visitor choose.
    """
    if len(values) > 1:
        raise ValueError("said twice")
    return values[0].strip() if values else ""


def _text(claim: object) -> str:
    if not isinstance(claim, str):
        raise ValueError("no text")
    return claim.strip()


def _check_person(person: str) -> None:
    # A comma joins what was said twice (RFC 9110, 5.3); in braces is what Caddy has no value for.
    is_joined = any(mark in person for mark in ",{}")
    if len(person) > _MOST_CHARS or is_joined or not person.isprintable():
        raise ValueError("no name of a person")


def _listed(text: str) -> frozenset[str]:
    if len(text) > _MOST_CHARS_OF_LISTS or not text.isprintable():
        raise ValueError("no list of groups")
    return frozenset(
        group for one in text.split(",") for part in one.split("|") if (group := part.strip())
    )


def _decoded(name: str) -> str:
    """Return a name to be shown; some proxies encode one that is not ASCII (RFC 2047)."""
    name = name[:_MOST_CHARS]
    if not name.startswith("=?"):
        return name
    try:
        return str(make_header(decode_header(name)))
    except (MessageError, LookupError, ValueError):
        return name
