"""One front for identities, hosts, invitations and admission."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import structlog

from wax.access.admission import Admission, Visitor
from wax.access.host_secrets import HostSecrets
from wax.access.keyring import Keyring
from wax.access.published_keys import PublishedKeys
from wax.access.signed_tokens import claims
from wax.access.vouching import Vouching
from wax.config.opening_hours import OpeningHours, zone_of
from wax.errors import ForbiddenError
from wax.records.entries import Invited
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from wax.access.admission import Grant
    from wax.access.host_decisions import HostDecisions
    from wax.access.keyring import Invitation
    from wax.clock import Clock
    from wax.config.access import AccessSettings
    from wax.protocol.http_bodies import Purpose
    from wax.records.records import Records


_LOG = structlog.get_logger(__name__)


@dataclass(frozen=True, slots=True)
class Shown:
    """The cookies that a request carries; None for each that is missing.

    `said` has the headers of `Access.asked`, by lower-case names, if a trusted proxy sent them.
    """

    identity: str | None = None
    host: str | None = None
    said: Mapping[str, Sequence[str]] = field(default_factory=dict)


class Access:
    """Call it from the event loop; what must outlast the server goes to the records."""

    def __init__(
        self,
        settings: AccessSettings,
        records: Records,
        clock: Clock,
        secret: bytes,
        decisions: HostDecisions,
    ) -> None:
        self._records = records
        self._clock = clock
        self._keyring = Keyring(secret, self._now_s)
        lasting = records.lasting
        self.admission = Admission(
            settings,
            OpeningHours.of(settings.hours, zone_of(settings.time_zone)),
            decisions,
            lasting.bans,
        )
        self._proxy = settings.proxy
        self._keys = PublishedKeys(settings.proxy.keys) if settings.proxy.token else None
        self._vouching = Vouching(settings.proxy, self._claims)
        self._hosts = HostSecrets(lasting.host_cookies, records.keep_host_cookie)
        self.reused_at: str | None = None
        """The newest address that used a replaced host's cookie, which may be a stolen copy."""
        self._invited: defaultdict[str, dict[str, Invited]] = defaultdict(dict)
        """The invitations used, by identity and then by invitation."""
        for one in lasting.invited:
            self._invited[one.identity][one.invitation] = one

    async def run(self) -> None:
        """Keep the keys of signed tokens new, until cancelled; there must be some."""
        assert self._keys is not None
        await self._keys.run()

    # --- who somebody is -------------------------------------------------------------------

    def identity_of(self, shown: Shown) -> str | None:
        """Return a browser's identity; None if it has no valid cookie of ours."""
        return self._keyring.identity_of(shown.identity)

    def new_identity(self, *, bound: bool = False) -> str:
        """Return a cookie with a new identity (`Keyring.new_identity`)."""
        return self._keyring.new_identity(bound=bound)

    @property
    def asked(self) -> frozenset[str]:
        """The headers by which a trusted proxy says who somebody is; empty if none is asked."""
        return self._vouching.names

    def visitor(self, shown: Shown, address: str) -> Visitor:
        """Return who sent a request; without a valid cookie, their identity is empty.

        Where a proxy is asked, they are whom it names, and their cookie is only their browser's.
        """
        identity = self.identity_of(shown) or ""
        sign_in = ""
        if self._proxy.host_link:
            sign_in = self._hosts.sign_in(shown.host, self._now_s())
            if shown.host is not None and not sign_in:
                self._watch_for_copies(shown.host, address)
        if not self._proxy.is_used:
            return Visitor(identity, address, sign_in, self._invited_to(identity))
        vouched = self._vouching.judge(shown.said, self._clock.now_s())
        person = vouched.identity or (identity if sign_in else "")
        return Visitor(
            *(person, address, sign_in, self._invited_to(person)), vouched=vouched, device=identity
        )

    def _claims(self, token: str) -> Mapping[str, Any]:
        assert self._keys is not None, "the configuration has keys where it has a token"
        issuer, audience = self._proxy.issuer, self._proxy.audience
        return claims(token, self._keys.get, audience=audience, issuer=issuer)

    def on_device(self, visitor: Visitor, device: str) -> Visitor:
        """Return a visitor whose browser has this identity; raises `NotAdmittedError`."""
        if not self._proxy.is_used:
            return replace(visitor, identity=device)
        self.admission.check_vouched(visitor)
        return replace(visitor, identity=visitor.identity or device, device=device)

    def refreshed(self, visitor: Visitor) -> Visitor:
        """Return a visitor with current invitations and rights: what has ended counts no more."""
        is_signed_in = self._hosts.is_signed_in(visitor.sign_in, self._now_s())
        vouched = None if visitor.vouched is None else visitor.vouched.at(self._clock.now_s())
        return replace(
            visitor,
            sign_in=visitor.sign_in if is_signed_in else "",
            invited_to=self._invited_to(visitor.identity),
            vouched=vouched,
        )

    def _watch_for_copies(self, cookie: str, address: str) -> None:
        if self._hosts.was_replaced(cookie, self._now_s()):
            if self.reused_at != address:
                _LOG.warning("a host's cookie that was replaced is used again", address=address)
            self.reused_at = address

    def admit(self, visitor: Visitor) -> Grant:
        """Return a visitor's rights; raises `NotAdmittedError` with a sentence for them."""
        return self.admission.check(visitor, self._now_s())

    # --- the host ----------------------------------------------------------------------------

    def new_host_link(self) -> str:
        """Return the secret of a link that makes the first person who opens it host.

        None opens where `[access.proxy] host_link` is off.
        """
        return self._hosts.new_link(self._now_s())

    def become_host(self, secret: str) -> str:
        """Return the host's cookie for a link's secret; raises `ForbiddenError`."""
        if not self._proxy.host_link:
            raise ForbiddenError(Sentence("link.off"))
        cookie = self._hosts.exchange(secret, self._now_s())
        if cookie is None:
            raise ForbiddenError(Sentence("link.used"))
        return cookie

    def renew_cookie(self, shown: Shown) -> str | None:
        """Return the cookie that replaces a host's; None if it stays or is not a host's."""
        return None if shown.host is None else self._hosts.rotate(shown.host, self._now_s())

    def sign_out_others(self, host: Visitor) -> int:
        """End all other hosts' sign-ins and unused links; returns how many were signed in."""
        self.reused_at = None
        return self._hosts.sign_out_others(host.sign_in)

    # --- invitations -------------------------------------------------------------------------

    def invite(self, purpose: Purpose, *, uses: int, valid_s: float) -> tuple[str, float]:
        """Return a new invitation's token, and when it expires in seconds since 1970."""
        return self._keyring.invite(purpose, uses=uses, valid_s=valid_s), self._now_s() + valid_s

    def enter(self, token: str, identity: str) -> Invitation:
        """Use an invitation: each person counts once, however often; raises `ForbiddenError`."""
        invitation = self._keyring.invitation_of(token)
        if invitation.id not in self._invited.get(identity, ()):
            if self._uses(invitation.id) >= invitation.uses:
                raise ForbiddenError(Sentence("invitation.used_up"))
            use = Invited(invitation.id, identity, invitation.purpose, invitation.ends_s)
            self._invited[identity][invitation.id] = use
            self._records.keep_invited(use)
        return invitation

    def _uses(self, invitation: str) -> int:
        return sum(invitation in uses for uses in self._invited.values())

    def _invited_to(self, identity: str) -> Purpose | None:
        uses = self._invited.get(identity, {})
        purposes = {one.purpose for one in uses.values() if self._now_s() < one.until_s}
        return "queue" if "queue" in purposes else "watch" if "watch" in purposes else None

    # --- the host's acts on admission --------------------------------------------------------

    def ban(self, visitor: Visitor) -> None:
        """Ban somebody and their address for a day."""
        self._records.keep_ban(self.admission.ban(visitor, self._now_s()))

    def close(self, is_closed: bool) -> None:
        """Close to guests, or reopen."""
        self.admission.close(is_closed, self._now_s())

    @property
    def is_open(self) -> bool:
        return self.admission.is_open(self._now_s())

    @property
    def opens_wall_ms(self) -> float | None:
        """When guests are next admitted (ms since 1970); None if they are now, or if unknown."""
        opens_s = self.admission.opens_s(self._now_s())
        return None if opens_s is None else opens_s * 1000

    def _now_s(self) -> float:
        return self._clock.wall_ms() / 1000
