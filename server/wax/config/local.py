"""`[local]`: the hand control of a person aboard."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from wax.config.table import ConfigTable

Deflection = Annotated[float, Field(ge=-1, le=1)]


class ActSettings(ConfigTable):
    """One act of `[local] script`: what the simulated person aboard does at `at_s`."""

    at_s: Annotated[float, Field(ge=0, le=3600)]
    """Seconds after the script's beginning."""
    for_s: Annotated[float, Field(ge=0.1, le=60)] = 0.5
    """Seconds for which it is done."""
    linear: Deflection = 0.0
    """How far the stick is pushed ahead."""
    angular: Deflection = 0.0
    """How far the stick is pushed to the left, which turns the robot."""
    lateral: Deflection = 0.0
    """How far the stick for sideways is pushed to the left."""
    press: Literal["stop", "wait", "go_on", "left", "right", "none"] = "none"
    """The button that is pressed."""


class LocalSettings(ConfigTable):
    """A person aboard, as in a powered wheelchair, with a hand control of their own that outranks
    every operator: touched, the robot is theirs at once; released, it stands for a moment, and then
    an operator may drive on, from neutral. It is read in the driver process, so that the person
    drives and stops even when the server is frozen or dead: the process outlives a server that was
    killed, until the next one is started (with systemd: KillMode=process). While the control does
    not answer nobody drives. A Stop of the person's stays in force, whatever is started again,
    until they ask to go on (a power cut within seconds of it may lose it). A Stop on the page holds
    operators, never the person.

    WAX is no medical device: such a robot needs an emergency stop in hardware within their reach.
    """

    source: Literal["none", "robot", "serial"] = "none"
    """Where the hand control is: "serial" is one on a line of its own
    (server/wax/robot/hand/line.py describes its frames byte by byte), "robot" the robot's own: that
    of its driver (server/wax/driver/hand.py), or of the simulated person, who follows the script
    below. A robot without a watchdog of its own (serial: dialect = "bytes") can have nobody
    aboard."""
    url: Annotated[str, Field(min_length=1)] = "/dev/ttyACM1"
    """The control's port, as listed by `wax devices`, or any URL that pyserial opens."""
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 115_200
    """Bits a second; it must match the control's program."""
    stick: Literal["drives", "shares"] = "drives"
    """What the stick does while an operator is connected and may drive: "drives" takes the robot
    over; "shares" lets pass as much of the operator's driving as the stick is pushed ahead, none of
    it at rest, to a side or back. Otherwise the stick drives, once it was seen at rest."""
    pause_s: Annotated[float, Field(ge=0.5, le=60)] = 2.0
    """Seconds for which the robot stands after the person has let go, before an operator may
    drive."""
    max_fraction: Annotated[float, Field(ge=0.05, le=1)] = 0.5
    """The fraction of the robot's speed that the stick reaches, pushed as far as it goes."""
    dead_zone: Annotated[float, Field(ge=0.02, le=0.5)] = 0.1
    """How far from its middle the stick counts as at rest, as a fraction of its way."""
    silence_ms: Annotated[int, Field(ge=60, le=1000)] = 150
    """The robot stops after this many milliseconds without a word from the control."""
    script: Annotated[list[ActSettings], Field(max_length=64)] = []
    """What the simulated person does, to show operators what happens and let them practise. What an
    act leaves out does nothing."""
    script_s: Annotated[float, Field(ge=1, le=3600)] = 60.0
    """Seconds after which the script begins again."""

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
