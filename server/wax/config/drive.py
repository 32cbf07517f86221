"""`[drive]`: how commands become motion."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from wax.config.table import ConfigTable


class DriveSettings(ConfigTable):
    """How commands become motion."""

    command_rate_hz: Annotated[float, Field(ge=20, le=50)] = 50.0
    """How many times a second the page sends a set-point, at most; on a slow link fewer, down to
    10. Any of them may be lost; more of them shorten the gap that a loss leaves, and load the
    uplink."""
    loop_hz: Annotated[float, Field(ge=20, le=100)] = 50.0
    """How many times a second the robot gets a set-point."""
    max_age_ms: Annotated[float, Field(ge=50, le=1000)] = 150.0
    """A command counts for this many milliseconds after it was sent, plus the link's delay, which
    is half the least round trip in this turn; then the robot stops. 150 bridges six lost commands.
    A page that lies about its clock gains no more than the round trip and 350 ms, by the server's
    own clock."""
    max_command_age_ms: Annotated[float, Field(ge=50, le=2000)] = 500.0
    """The most milliseconds for max_age_ms and the link's delay together, not less than max_age_ms.
    Over a slower link people can watch, but not drive."""
    slow_picture_age_ms: Annotated[float, Field(ge=100, le=60_000)] = 400.0
    """An operator whose picture is older than this many milliseconds, not counting the link's delay
    but with what the source's clock may err by (100 for a USB camera, 200 for a network camera),
    can only drive at slow speed, because they cannot see what they are doing."""
    stop_picture_age_ms: Annotated[float, Field(ge=100, le=60_000)] = 800.0
    """An operator whose picture is older than this many milliseconds, counted in the same way,
    cannot drive at all. Not less than slow_picture_age_ms."""
    max_stop_distance_m: Annotated[float, Field(gt=0, le=10)] = 0.3
    """The most metres that the robot may travel from losing its operator to standing still. The
    longer the link's delay, the slower it drives."""
    slow_fraction: Annotated[float, Field(gt=0, le=1)] = 0.3
    """What "slow" is, as a fraction of the robot's limits; "fast" is the full limits."""
    click_to_move: bool = False
    """Whether an operator may choose to drive by clicks: each moves the robot for up to two seconds
    (by their page's count), until another click, any key or Stop. It is for people who cannot
    hold a control down; but nobody's hand is on the robot meanwhile, so allow it only where two
    seconds of travel can harm nobody. All else that stops the robot still does: a page that is
    hidden, hangs or is cut off."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.max_command_age_ms < self.max_age_ms:
            raise ValueError(
                f"max_command_age_ms is {self.max_command_age_ms:g} and max_age_ms"
                f" {self.max_age_ms:g}; max_command_age_ms must be the larger one"
            )
        if self.stop_picture_age_ms < self.slow_picture_age_ms:
            raise ValueError(
                f"stop_picture_age_ms is {self.stop_picture_age_ms:g} and slow_picture_age_ms"
                f" {self.slow_picture_age_ms:g}; stop_picture_age_ms must be the larger one"
            )
        return self
