"""The host's decisions, in force until the host changes them.

The message and the muted people are lost with the server; the switches are kept
(`wax.session.kept_state`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from wax.protocol.host_switches import HostSwitches
from wax.sentence import Sentence

BLANKED: Final = Sentence("drive.blanked")


@dataclass(slots=True)
class HostDecisions:
    """`message` is shown to all until `message_ends_s`, for good where that is None.

    The Stop of the `muted` identities, and of everybody at `muted_addresses` but the operator, is
    ignored.
    """

    switches: HostSwitches = field(default_factory=HostSwitches)
    message: str = ""
    message_ends_s: float | None = None
    muted: set[str] = field(default_factory=set)
    muted_addresses: set[str] = field(default_factory=set)

    def message_at(self, now_s: float) -> tuple[str, float | None]:
        """Return the message shown now, empty for none, and when it ends."""
        if self.message_ends_s is not None and now_s >= self.message_ends_s:
            return "", None
        return self.message, self.message_ends_s

    @property
    def on_hold(self) -> Sentence | None:
        """Why the host lets nobody drive; None if people may."""
        return BLANKED if self.switches.is_blanked else None
