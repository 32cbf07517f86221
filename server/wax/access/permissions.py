"""The permission table: one row for each message and route, each checked in one place.

A role is what somebody is now: a host by a secret, the operator by their turn, an observer by
admission. An operator becomes an adviser while the person aboard controls the robot; that person
outranks every row and needs none, since the robot's own computer reads their hand control
(`wax.control.local_hand`). An embed only watches in a frame on another site, whatever cookies its
browser has. A stranger has a page but no place in the room. The house is the host's home
automation, whoever uses it; it is no browser and never drives.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, get_args

from wax.errors import ForbiddenError
from wax.protocol import messages
from wax.protocol.host_switches import SWITCHES
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Mapping

Role = Literal["stranger", "embed", "observer", "adviser", "operator", "host", "house"]
Act = type | str
"""A message of the protocol, a route as ``METHOD /path``, or one of those below."""

SPEAK: Final = "a voice"
"""Sound from the page's microphone, which does not come as a message."""
DIAGNOSIS: Final = "what fails"
"""Reading the details of a fault, such as the port of a robot that does not answer."""

ROLES: Final[tuple[Role, ...]] = get_args(Role)

_HOUSE: Final = frozenset[Role]({"house"})
_ANYBODY: Final = frozenset(ROLES) - _HOUSE
_WATCHING: Final = _ANYBODY - {"stranger"}
_INSIDE: Final = _WATCHING - {"embed"}
_DRIVING: Final = frozenset[Role]({"operator", "host"})
_IN_CHARGE: Final = frozenset[Role]({"adviser", "operator", "host"})
_HOST: Final = frozenset[Role]({"host"})

PERMISSIONS: Final[Mapping[Act, frozenset[Role]]] = {
    # Watching and waiting. Whether a stranger may enter is decided by admission.
    messages.Ping: _WATCHING,
    messages.Report: _WATCHING,
    messages.SetName: _INSIDE,
    messages.Want: _WATCHING,
    messages.Look: _INSIDE,
    messages.Follow: _INSIDE,
    messages.Received: _WATCHING,
    messages.Join: _INSIDE,
    messages.Leave: _INSIDE,
    messages.Here: _INSIDE,
    # Driving, and stopping.
    messages.Drive: _DRIVING,
    messages.Operate: _INSIDE,  # `[[controls]] roles` decides for each control
    messages.Stop: _INSIDE | _HOUSE,
    messages.Release: _IN_CHARGE | _HOUSE,  # the house only if `[mqtt] release` allows it
    # Speaking to the people beside the robot, which viewers never may.
    SPEAK: _IN_CHARGE,
    messages.KeepTape: _IN_CHARGE,
    messages.SetTask: _IN_CHARGE,
    messages.Disown: _INSIDE,  # whoever drove that turn
    # The host's acts; the switches that home automation has are its acts, too.
    **{one.act: _HOST | _HOUSE if one.at_home else _HOST for one in SWITCHES.values()},
    messages.EndTurn: _HOST,
    messages.Remove: _HOST,
    messages.Mute: _HOST,
    messages.MuteAddress: _HOST,
    messages.Announce: _HOST,
    messages.Invite: _HOST,
    messages.SignOutOthers: _HOST,
    # Pages and requests.
    "GET /": _ANYBODY,
    "GET /assets": _ANYBODY,
    "GET /page.css": _ANYBODY,
    "GET /preview": _ANYBODY,
    "GET /open.ics": _ANYBODY,
    "GET /oembed": _ANYBODY,
    "GET /healthz": _ANYBODY,
    "GET /readyz": _ANYBODY,
    "POST /api/host": _ANYBODY,
    "POST /api/enter": _ANYBODY,
    "POST /api/offer": _ANYBODY,
    "POST /api/embed": _ANYBODY,
    "POST /api/queue": _ANYBODY,
    "POST /api/seat": _ANYBODY,
    "GET /api/ice": _ANYBODY,
    "GET /api/present": _ANYBODY,
    "POST /api/stop": _INSIDE,
    "POST /api/release": _IN_CHARGE,
    DIAGNOSIS: _HOST,
    "GET /api/status": _HOST,
    "POST /api/proof": _HOST,
    "GET /api/proof": _HOST,
    "GET /api/proof/record": _HOST,
}

_ONLY: Final[Mapping[frozenset[Role], Sentence]] = {
    _ANYBODY: Sentence("may.watchers"),
    _WATCHING: Sentence("may.watchers"),
    _INSIDE: Sentence("may.watchers"),
    _DRIVING: Sentence("may.operator"),
    _IN_CHARGE: Sentence("may.operator"),
    _HOST: Sentence("may.host"),
}


def may(role: Role, act: Act) -> bool:
    """Whether this role may do this; nobody may do what is not in the table."""
    return role in PERMISSIONS.get(act, frozenset())


def check(role: Role, act: Act) -> None:
    """Raise `ForbiddenError` with a sentence unless `may` allows it."""
    if not may(role, act):
        if role == "adviser" and may("operator", act):
            raise ForbiddenError(Sentence("aboard.advise"))
        people = PERMISSIONS.get(act, frozenset()) - _HOUSE
        raise ForbiddenError(_ONLY.get(people, Sentence("may.nobody")))
