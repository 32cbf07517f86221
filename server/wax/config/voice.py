"""`[voice]`: speaking through the robot."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.table import ConfigTable


class VoiceSettings(ConfigTable):
    """`[voice]`: speaking to the people beside the robot."""

    speaker: Annotated[str, Field(min_length=1)] = "none"
    open_microphone: bool = False
