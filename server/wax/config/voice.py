"""`[voice]`: speaking through the robot."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.table import ConfigTable


class VoiceSettings(ConfigTable):
    """Speaking to the people beside the robot: the operator's microphone, and the host's, one voice
    at a time. Their pages need HTTPS for that. Everybody else hears it by the robot's
    microphone.
    """

    speaker: Annotated[str, Field(min_length=1)] = "none"
    """Where a voice is played: "none" (nobody can speak), "robot" (the robot's own speaker, if it
    has one; in the simulated robot's flat people answer), "speaker" (the system's default), one
    by number or name ("speaker:2", "speaker:USB"; `wax devices` lists them), a file that ends in
    .wav, to which it is added, or your own class as "package.module:Class"."""
    open_microphone: bool = False
    """Whether those who may speak can leave the microphone open. If not, they hold a button, or the
    key T, while they speak."""
