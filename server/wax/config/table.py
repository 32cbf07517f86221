"""What all tables of the configuration share."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from wax.config.allowed import said


class ConfigTable(BaseModel):
    """A table of the configuration: no other keys, no conversion, no change."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


Name = Annotated[
    str,
    Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,15}$"),
    said("a name of at most 16 letters, digits and _, not beginning with a digit"),
]


def check_apart(problem: str, names: list[str]) -> None:
    """Raise `ValueError` with `problem` and the first duplicate name."""
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(problem.format(twice))
