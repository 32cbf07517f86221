"""What the host has decided for everybody, until they decide otherwise.

Message and muted people end with the server; the rest is kept (`kept_state`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from wax.sentence import Sentence

BLANKED: Final = Sentence("drive.blanked")


@dataclass(slots=True)
class HostDecisions:
    """`max_fraction` of the robot's speed is what guests may use; `message` is shown to all until
    `message_ends_s`, for good where that is None.

    While `is_blanked`, everybody sees a card instead of the picture and hears nothing, and the
    robot stands. The Stop of the `muted` identities, and of everybody at `muted_addresses` who does
    not drive, is not heard, and of voices nobody's while `are_voices_muted`.
    """

    max_fraction: float = 1.0
    is_blanked: bool = False
    are_voices_muted: bool = False
    message: str = ""
    message_ends_s: float | None = None
    muted: set[str] = field(default_factory=set)
    muted_addresses: set[str] = field(default_factory=set)

    def message_at(self, now_s: float) -> tuple[str, float | None]:
        """Return what everybody is shown now, empty for nothing, and when that ends."""
        if self.message_ends_s is not None and now_s >= self.message_ends_s:
            return "", None
        return self.message, self.message_ends_s

    @property
    def on_hold(self) -> Sentence | None:
        """Why nobody can drive by the host's wish."""
        return BLANKED if self.is_blanked else None
