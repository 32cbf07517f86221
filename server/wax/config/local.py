"""`[local]`: the hand control of a person aboard."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from wax.config.table import ConfigTable

Deflection = Annotated[float, Field(ge=-1, le=1)]


class ActSettings(ConfigTable):
    """One act of `[local] script`: what the simulated person aboard does at `at_s`."""

    at_s: Annotated[float, Field(ge=0, le=3600)]
    for_s: Annotated[float, Field(ge=0.1, le=60)] = 0.5
    linear: Deflection = 0.0
    angular: Deflection = 0.0
    press: Literal["stop", "wait", "go_on", "left", "right", "none"] = "none"


class LocalSettings(ConfigTable):
    """`[local]`: the hand control of a person aboard, who outranks every operator."""

    source: Literal["none", "robot", "serial"] = "none"
    url: Annotated[str, Field(min_length=1)] = "/dev/ttyACM1"
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 115_200
    stick: Literal["drives", "shares"] = "drives"
    pause_s: Annotated[float, Field(ge=0.5, le=60)] = 2.0
    max_fraction: Annotated[float, Field(ge=0.05, le=1)] = 0.5
    dead_zone: Annotated[float, Field(ge=0.02, le=0.5)] = 0.1
    silence_ms: Annotated[int, Field(ge=60, le=1000)] = 150
    script: Annotated[list[ActSettings], Field(max_length=64)] = []
    script_s: Annotated[float, Field(ge=1, le=3600)] = 60.0

    @property
    def is_on(self) -> bool:
        """Whether there is a hand control, and so a person aboard."""
        return self.source != "none"

    @model_validator(mode="after")
    def _is_in_time(self) -> Self:
        late = next((act for act in self.script if act.at_s + act.for_s >= self.script_s), None)
        if late is not None:
            raise ValueError(
                f"the act at {late.at_s:g} s ends after script_s, {self.script_s:g} s; make"
                " script_s longer"
            )
        return self
