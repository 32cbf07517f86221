"""Everything that WAX raises on purpose, and how each is told to the other side.

WaxError
 ├── ConfigError      the configuration cannot be used; the server does not start
 ├── SourceError      a camera, microphone or file does not deliver; retried
 ├── DriverError      the robot cannot be reached; retried, nothing moves meanwhile
 ├── ProtocolError    bytes from outside that are not a message of ours; refused and counted
 ├── SignallingError  an offer that cannot be answered
 ├── FullError        no room for one more viewer
 ├── TooOftenError    one address asks for connections too often
 ├── ForbiddenError   somebody who may not asks for something
 └── StartError       something the server needs at start is missing or taken
"""

from __future__ import annotations

from typing import Final


class WaxError(Exception):
    """A sentence for a person: what is wrong and what to do."""


class ConfigError(WaxError):
    """All problems of a configuration, one a line."""


class SourceError(WaxError):
    """A source that cannot be opened or has stopped delivering."""


class DriverError(WaxError):
    """The robot cannot be reached."""


class ProtocolError(WaxError):
    """A message that is not one of ours."""


class SignallingError(WaxError):
    """An offer that cannot be answered."""


class FullError(WaxError):
    """The configured number of viewers is reached."""


class TooOftenError(WaxError):
    """One address asks for connections too often."""


class ForbiddenError(WaxError):
    """Somebody asks for what they may not do, or not now."""


class StartError(WaxError):
    """The server cannot start."""


HTTP_STATUS: Final[dict[type[WaxError], int]] = {
    ProtocolError: 400,
    SignallingError: 400,
    ForbiddenError: 403,
    TooOftenError: 429,
    FullError: 503,
}
"""The one table from an error to an HTTP status; anything else is 500."""
