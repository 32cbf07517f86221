"""The JSON bodies of the page's HTTP requests, and of the answers to them."""

from __future__ import annotations

from operator import not_
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from wax.protocol.messages import Counter, SentToRoom, ViewerInfo
from wax.sentence import Sentence

MAX_BODY_BYTES: Final = 65_536
_SMALL_BYTES: Final = 2048
"""The limit of every body but an offer's."""
MAX_SDP_CHARS: Final = 32_768
MAX_TOKEN_CHARS: Final = 512

Client = Annotated[str, Field(pattern=r"^[A-Za-z0-9-]{8,64}$")]
"""A secret that tells a tab from its browser's others; alone, it admits nobody. It identifies a
page without a cookie, to watch in another site's frame or to press Stop."""
Purpose = Literal["watch", "queue"]
"""What an invitation lets people do."""
Token = Annotated[str, Field(min_length=1, max_length=MAX_TOKEN_CHARS)]


class RequestBody(BaseModel):
    """A JSON body of at most `most_bytes`."""

    model_config = ConfigDict(extra="forbid", strict=True)
    most_bytes: ClassVar[int] = _SMALL_BYTES


class OfferBody(RequestBody):
    """A page's session description, and its tab.

    A browser that cannot make an offer sends none, is answered with ours, and then `answers` it.
    """

    most_bytes = MAX_BODY_BYTES
    sdp: Annotated[str, Field(max_length=MAX_SDP_CHARS)]
    client: Client
    answers: bool = False


class HostLink(RequestBody):
    """The secret of a host link."""

    secret: Token


class EntryBody(RequestBody):
    """An invitation's token."""

    token: Token


class QueueBody(RequestBody):
    """What a page in a LiveKit room wants: to join the queue, leave it, or keep its place.

    The server cuts `name`, as in the message of that name.
    """

    client: Client
    wants: Literal["join", "leave", "here", "stay"]
    name: Annotated[str, Field(max_length=200)] | None = None


class SeatBody(RequestBody):
    """A tab that wants to watch in a LiveKit room, or to go on there; or that `leaves`."""

    client: Client
    leaves: bool = False


class StopPress(RequestBody):
    """A press of Stop, and its tab if the request names one; as `messages.Stop`."""

    client: Client | None = None
    press: Counter | None = None


class StopRelease(RequestBody):
    """Which stop to release, and the tab that does."""

    client: Client | None = None
    stop: Counter


class Lifted(RequestBody):
    """The host's confirmation that the wheels are off the floor."""

    lifted: Literal[True]


class _Answer(BaseModel):
    model_config = ConfigDict(frozen=True)


class Done(_Answer):
    """What was asked for is done."""

    ok: Literal[True] = True


class IceServer(_Answer):
    """A STUN or TURN server as browsers expect it; only TURN needs a name and a password."""

    urls: str | list[str]
    username: Annotated[str, Field(exclude_if=not_)] = ""
    credential: Annotated[str, Field(exclude_if=not_)] = ""


class IceAnswer(_Answer):
    """What the page needs before it connects, in the spelling of browsers."""

    iceServers: list[IceServer]  # noqa: N815
    """The STUN and TURN servers that the host configured."""
    relayOnly: bool  # noqa: N815
    """Only the relay may be used, even where a direct connection is possible."""
    wantsCandidates: bool  # noqa: N815
    """Whether the server needs the offer's candidates, which take a moment to gather."""


class EntryAnswer(_Answer):
    """What an invitation is for."""

    purpose: Purpose


class OfferAnswer(_Answer):
    """The server's session description, empty for a page that `answers`.

    `host` if it takes this page for the host's.
    """

    sdp: str
    host: Annotated[bool, Field(exclude_if=not_)] = False


class StopAnswer(_Answer):
    """The number of the stop in force."""

    stop: int


ProofState = Literal["never", "running", "done", "failed"]


class ProofProgress(_Answer):
    """The progress of the proof of the stop; `line` describes its step, `record` is a path."""

    state: ProofState
    line: Sentence | None
    record: str | None


BODIES: Final[dict[str, Any]] = {
    "api/host": HostLink,
    "api/enter": EntryBody,
    "api/offer": OfferBody,
    "api/embed": OfferBody,
    "api/queue": QueueBody,
    "api/seat": SeatBody,
    "api/stop": StopPress,
    "api/release": StopRelease,
    "api/proof": Lifted,
}
"""What the page posts, by path."""

ANSWERS: Final[dict[str, Any]] = {
    "api/ice": IceAnswer,
    "api/host": Done,
    "api/enter": EntryAnswer,
    "api/offer": OfferAnswer | SentToRoom,
    "api/embed": OfferAnswer,
    "api/queue": ViewerInfo,
    "api/seat": SentToRoom,  # nobody reads the empty answer to a tab that leaves
    "api/stop": StopAnswer,
    "api/release": Done,
    "api/proof": ProofProgress,
}
"""What the server answers, by path, if it does what was asked."""
