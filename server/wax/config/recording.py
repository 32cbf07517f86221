"""`[recording]`: the tape, which records picture, sound and driving for a while."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.allowed import printable
from wax.config.table import ConfigTable


class RecordingSettings(ConfigTable):
    """The tape: picture and sound as they were sent in the best quality, and what was commanded and
    what became of it, on disk for a while. Everybody sees on their page that it runs. `wax tape`
    lists, keeps, exports and deletes what is on it, `wax replay` plays it. A power cut costs it
    about a second; what it cuts off is mended at the next start, or by `wax tape repair`, so that
    other programs read it.
    """

    enabled: bool = False
    """Whether to record. The best rendition is then always encoded, whether anybody watches or
    not."""
    folder: str = ""
    """The folder. "" is the folder tape beside the records. It shows and tells everything, so it is
    made for its owner only."""
    max_gb: Annotated[float, Field(ge=0.1, le=100_000)] = 20.0
    """The most gigabytes that the tape takes; then the oldest goes, and last what was kept because
    of a fault or by an operator. What the host keeps never goes by itself. A day at 1 Mbit/s
    takes 11."""
    min_free_gb: Annotated[float, Field(ge=0, le=100_000)] = 2.0
    """The gigabytes that stay free on its disk; the tape stops before, the robot does not."""
    keep_days: Annotated[float, Field(ge=0.01, le=3650)] = 7.0
    """After how many days what the host has not kept is deleted."""
    segment_s: Annotated[float, Field(ge=10, le=600)] = 60.0
    """The shortest part of the tape, in seconds; each is a few files, and the next begins with the
    next keyframe. Parts are kept and deleted as a whole."""
    sound: bool = True
    """Whether the sound is on the tape, too. Ask what your law says about recording people's
    voices."""
    cameras: bool = True
    """Whether the further cameras are on the tape, too, each in the best of its renditions, which
    is then always encoded."""
    purpose: Annotated[str, printable(0, 160)] = ""
    """What the tape is used for, besides seeing what happened. Everybody reads it on the page, and
    for a minute after each turn its operator can say that this turn is not to be used: `wax tape
    export` then leaves it out.

    Example: purpose = "A robot learns from it how to tidy up."
    """
    task: Annotated[str, printable(0, 100)] = ""
    """What operators do, in a data set that `wax tape export` makes.

    Example: task = "Drive to the red post."
    """
    ask_task: bool = False
    """Whether the page asks operators what they are going to do; their answer replaces `task`. They
    can write anything, their own names too."""
    names: bool = False
    """Whether people's names are on the tape; otherwise people are numbers. Addresses never are."""
