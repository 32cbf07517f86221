"""The bases of `[robot] base`, and their wheels by name."""

from __future__ import annotations

from typing import Final, Literal

Base = Literal["differential", "mecanum", "omni"]

WHEELS_OF: Final[dict[Base, tuple[str, ...]]] = {
    "differential": ("left", "right"),
    "mecanum": ("front_left", "front_right", "back_left", "back_right"),
    "omni": ("left", "right", "back"),
}
WHEELS: Final = tuple(dict.fromkeys(name for names in WHEELS_OF.values() for name in names))
