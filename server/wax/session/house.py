"""What the host has decided for everybody, until they decide otherwise or the server ends."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class House:
    """`max_fraction` of the robot's speed is what guests may use; `message` is shown to all.

    While `is_blanked`, everybody sees a card instead of the picture and hears nothing.
    """

    max_fraction: float = 1.0
    is_blanked: bool = False
    message: str = ""
