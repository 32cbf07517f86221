"""The exceptions of WAX, and their HTTP statuses.

WaxError
 ├── ConfigError      the configuration cannot be used; the server does not start
 │    └── PluginError    … because a plug-in fails while it is built; it may not, later
 ├── SourceError      a camera, microphone or file does not deliver; retried
 ├── SpeakerError     a speaker cannot be opened, or takes no more; retried
 ├── DriverError      the robot cannot be reached; retried, nothing moves meanwhile
 ├── ProtocolError    bytes from outside that are not a valid message; refused and counted
 ├── SignallingError  an offer that cannot be answered
 ├── FullError        no room for one more viewer
 │    └── NoPlaceError  … here, but perhaps in a room of the cluster
 ├── TooOftenError    one address requests connections, or tries secrets, too often
 ├── NotForUsError    a request that is not meant for this server, or not by our own page
 ├── ForbiddenError   a request that its sender may not make, or not now
 │    └── NotAdmittedError  somebody who may not come in, or not stay
 ├── StateError       the folder for what outlives the server cannot be used
 └── StartError       something the server needs at its start is missing or in use
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.protocol.messages import Opening


class WaxError(Exception):
    """A sentence for a person: what is wrong and what to do.

    What a viewer gets to see is a `Sentence`, which their page says in their language; what only
    the host sees, and a plug-in's own words, are text. `str` of either is English.
    """

    def __init__(self, sentence: Sentence | str) -> None:
        super().__init__(sentence)

    @property
    def sentence(self) -> Sentence:
        """What is wrong, for a page."""
        (what,) = self.args
        return what if isinstance(what, Sentence) else says(str(what))


class _LaterError(WaxError):
    """What may be asked again after `retry_after_s` seconds."""

    def __init__(self, sentence: Sentence | str, *, retry_after_s: int = 1) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s


class ConfigError(WaxError):
    """All problems of a configuration, one a line."""


class PluginError(ConfigError):
    """A plug-in raised, or does not keep to its interface, while it was built."""


class SourceError(WaxError):
    """A source that cannot be opened or has stopped delivering."""


class SpeakerError(WaxError):
    """A speaker that cannot be opened or has stopped taking sound."""


class DriverError(WaxError):
    """The robot cannot be reached."""


class ProtocolError(WaxError):
    """Not a valid message."""


class SignallingError(WaxError):
    """An offer that cannot be answered."""


class FullError(_LaterError):
    """The configured number of viewers is reached."""


class NoPlaceError(FullError):
    """The places, or the upload, of this machine are taken; a room elsewhere may have some."""


class TooOftenError(_LaterError):
    """One address requests connections, or tries secrets, too often."""


class NotForUsError(WaxError):
    """A request that is not to be answered; `status` is what HTTP calls that."""

    def __init__(self, sentence: Sentence, status: int) -> None:
        super().__init__(sentence)
        self.status = status


class ForbiddenError(WaxError):
    """A request that its sender may not make, or not now."""


class NotAdmittedError(ForbiddenError):
    """Somebody who may not come in, or not stay.

    `openings` are when they may in the week to come; none if that is not the matter or not known.
    """

    def __init__(self, sentence: Sentence | str, openings: Sequence[Opening] = ()) -> None:
        super().__init__(sentence)
        self.openings = openings


class StateError(WaxError):
    """The folder or file for what outlives the server cannot be used."""


class StartError(WaxError):
    """The server cannot start."""


HTTP_STATUS: Final[dict[type[WaxError], int]] = {
    ProtocolError: 400,
    SignallingError: 400,
    ForbiddenError: 403,
    NotAdmittedError: 403,
    TooOftenError: 429,
    FullError: 503,
    NoPlaceError: 503,
}
"""The HTTP status of each error; any other is 500."""


def reason_of(error: Exception) -> str:
    """Return what an error says without its number, or its type's name if it says nothing."""
    return str(getattr(error, "strerror", None) or error) or type(error).__name__
