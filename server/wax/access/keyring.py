"""What the server signs: the identities of browsers, and invitations.

Both are signed with one secret, stored in the state folder; a new secret makes everybody a stranger
and ends all invitations.
"""

from __future__ import annotations

import hashlib
import secrets
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from itsdangerous import BadData, Signer, URLSafeSerializer
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from wax.errors import ForbiddenError
from wax.protocol.http_bodies import MAX_TOKEN_CHARS, Purpose
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

SECRET_BYTES: Final = 32
_AHEAD_S: Final = 300.0
"""The server's clock may be set back this far after an invitation was made."""

_BOUND: Final = "~"
"""The prefix of an identity that is valid only in a cookie that no other site can set."""

_SIGNED_BY: Final[dict[str, Any]] = {"key_derivation": "hmac", "digest_method": hashlib.sha256}


class _Signed(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    id: str = Field(min_length=8, max_length=32)
    purpose: Purpose
    uses: int = Field(ge=1, le=1000)
    made_s: int
    valid_s: int = Field(ge=1)


@dataclass(frozen=True, slots=True)
class Invitation:
    """Admits `uses` people until `ends_s` (seconds since 1970), to watch or also to queue."""

    id: str
    purpose: Purpose
    uses: int
    ends_s: float


class Keyring:
    """Signs and verifies with `secret`; `wall_s` returns the seconds since 1970."""

    def __init__(self, secret: bytes, wall_s: Callable[[], float]) -> None:
        self._identities = Signer(secret, salt="identity", **_SIGNED_BY)
        self._invitations = URLSafeSerializer(secret, salt="invitation", signer_kwargs=_SIGNED_BY)
        self._wall_s = wall_s

    def new_identity(self, *, bound: bool = False) -> str:
        """Return a cookie with a new identity, for which `is_bound` is true if `bound`."""
        mark = _BOUND if bound else ""
        return self._identities.sign(mark + secrets.token_urlsafe(12)).decode()

    def identity_of(self, cookie: str | None) -> str | None:
        """Return the identity in a cookie; None if we did not sign it."""
        if cookie is None or len(cookie) > MAX_TOKEN_CHARS:
            return None
        try:
            return self._identities.unsign(cookie).decode()
        except (BadData, UnicodeError):
            return None

    def invite(self, purpose: Purpose, *, uses: int, valid_s: float) -> str:
        """Return a new invitation's token."""
        signed = _Signed(
            id=secrets.token_urlsafe(9),
            purpose=purpose,
            uses=uses,
            made_s=int(self._wall_s()),
            valid_s=max(1, int(valid_s)),
        )
        token = self._invitations.dumps(signed.model_dump())
        return token if isinstance(token, str) else token.decode()

    def invitation_of(self, token: str) -> Invitation:
        """Verify a token; raises `ForbiddenError` with a sentence for its bearer."""
        try:
            if len(token) > MAX_TOKEN_CHARS:
                raise BadData("too long")
            signed = _Signed.model_validate(self._invitations.loads(token))
        except (BadData, ValidationError, UnicodeError) as error:
            raise ForbiddenError(Sentence("invitation.not_ours")) from error
        now_s = self._wall_s()
        if now_s < signed.made_s - _AHEAD_S:
            raise ForbiddenError(Sentence("invitation.too_early"))
        ends_s = float(signed.made_s + signed.valid_s)
        if now_s >= ends_s:
            raise ForbiddenError(Sentence("invitation.over"))
        return Invitation(signed.id, signed.purpose, signed.uses, ends_s)


def is_bound(cookie: str) -> bool:
    """Whether an identity is valid only in a cookie that no other site can set."""
    return cookie.startswith(_BOUND)
