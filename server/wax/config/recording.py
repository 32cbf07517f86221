"""`[recording]`: the tape, which records picture, sound and driving for a while."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.table import ConfigTable


class RecordingSettings(ConfigTable):
    """Nothing is recorded unless `enabled`."""

    enabled: bool = False
    folder: str = ""
    max_gb: Annotated[float, Field(ge=0.1, le=100_000)] = 20.0
    min_free_gb: Annotated[float, Field(ge=0, le=100_000)] = 2.0
    keep_days: Annotated[float, Field(ge=0.01, le=3650)] = 7.0
    segment_s: Annotated[float, Field(ge=10, le=600)] = 60.0
    sound: bool = True
    cameras: bool = True
    names: bool = False
