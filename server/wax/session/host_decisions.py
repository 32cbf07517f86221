"""What the host has decided for everybody, until they decide otherwise or the server ends."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from wax.sentence import Sentence

BLANKED: Final = Sentence("drive.blanked")


@dataclass(slots=True)
class HostDecisions:
    """`max_fraction` of the robot's speed is what guests may use; `message` is shown to all.

    While `is_blanked`, everybody sees a card instead of the picture and hears nothing, and the
    robot stands. The Stop of the `muted` identities, and of everybody at `muted_addresses` who does
    not drive, is not heard, and of voices nobody's while `are_voices_muted`.
    """

    max_fraction: float = 1.0
    is_blanked: bool = False
    are_voices_muted: bool = False
    message: str = ""
    muted: set[str] = field(default_factory=set)
    muted_addresses: set[str] = field(default_factory=set)

    @property
    def on_hold(self) -> Sentence | None:
        """Why nobody can drive by the host's wish."""
        return BLANKED if self.is_blanked else None
