"""The exceptions of WAX, and their HTTP statuses.

WaxError
 ├── ConfigError      the configuration cannot be used; the server does not start
 │    └── PluginError    … because a plug-in fails while it is built; it may not, later
 ├── SourceError      a camera, microphone or file does not deliver; retried
 ├── SpeakerError     a speaker cannot be opened, or has stopped playing; retried
 ├── DriverError      the robot cannot be reached; retried, nothing moves meanwhile
 ├── ProtocolError    bytes from outside that are not a valid message; refused and counted
 ├── SignallingError  an offer that cannot be answered
 ├── FullError        no place for one more viewer
 │    └── NoPlaceError  … here, but perhaps in a LiveKit room
 ├── TooOftenError    one address requests connections, or tries secrets, too often
 ├── NotForUsError    a request for another server, or from another site's page
 ├── ForbiddenError   a request that its sender may not make, or not now
 │    └── NotAdmittedError  somebody who may not enter, or not stay
 ├── StateError       the state folder cannot be used
 └── StartError       something the server needs at its start is missing or in use
"""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING, Final

from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.protocol.messages import Opening


class WaxError(Exception):
    """A sentence for a person: what is wrong and what to do.

    For viewers it is a `Sentence`, which the page shows in their language; for the host alone, and
    from a plug-in, it is plain text. `str` of either is English.
    """

    def __init__(self, sentence: Sentence | str) -> None:
        super().__init__(sentence)

    @property
    def sentence(self) -> Sentence:
        """The sentence in the form for a page."""
        (what,) = self.args
        return what if isinstance(what, Sentence) else says(str(what))


class _LaterError(WaxError):
    """A request that may be retried after `retry_after_s` seconds."""

    def __init__(self, sentence: Sentence | str, *, retry_after_s: int = 1) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s


class ConfigError(WaxError):
    """All problems of a configuration, one on each line."""


class PluginError(ConfigError):
    """A plug-in raised, or did not match its interface, while it was built."""


class SourceError(WaxError):
    """A source that cannot be opened or has stopped delivering."""


class SpeakerError(WaxError):
    """A speaker that cannot be opened or has stopped playing."""


class DriverError(WaxError):
    """The robot cannot be reached."""


class ProtocolError(WaxError):
    """Not a valid message."""


class SignallingError(WaxError):
    """An offer that cannot be answered."""


class FullError(_LaterError):
    """The configured number of viewers is reached."""


class NoPlaceError(FullError):
    """The places, or the upload, of this machine are taken; a LiveKit room may have a place."""


class TooOftenError(_LaterError):
    """One address requests connections, or tries secrets, too often."""


class NotForUsError(WaxError):
    """A request that must not be answered; `status` is its HTTP status."""

    def __init__(self, sentence: Sentence, status: int) -> None:
        super().__init__(sentence)
        self.status = status


class ForbiddenError(WaxError):
    """A request that its sender may not make, or not now."""


class NotAdmittedError(ForbiddenError):
    """Somebody who may not enter, or not stay.

    `openings` are the opening hours of the coming week; empty if hours are not the reason, or if
    they are unknown.
    """

    def __init__(self, sentence: Sentence | str, openings: Sequence[Opening] = ()) -> None:
        super().__init__(sentence)
        self.openings = openings


class StateError(WaxError):
    """The state folder, or a file in it, cannot be used."""


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


def is_disk_full(error: Exception) -> bool:
    """Return whether an error of the system or of FFmpeg says that there is no room on a disk."""
    return getattr(error, "errno", None) in (errno.ENOSPC, errno.EDQUOT)


def reason_of(error: Exception) -> str:
    """Return an error's message without its number, or its type's name if it has no message."""
    return str(getattr(error, "strerror", None) or error) or type(error).__name__
