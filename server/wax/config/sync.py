"""`[sync]`: which stream waits for which, and for how long."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from wax.config.table import ConfigTable

_MediaUnitMs = Literal[10, 20, 40, 60, 120]
_HoldbackMs = Annotated[float, Field(ge=0, le=2000)]
_SkewMs = Annotated[float, Field(ge=0, le=500)]


def _player(value: object) -> object:
    """Accept the built-in player's name of version 0.8 and before."""
    return "built-in" if value == "own" else value


class SyncSettings(ConfigTable):
    """`[sync.operator]` and `[sync.observer]`: which stream waits for which, and for how long."""

    policy: Literal["audio-master", "video-first"] = "audio-master"
    audio_mu_ms: Literal["auto", 10, 20, 40, 60, 120] = "auto"
    least_audio_mu_ms: _MediaUnitMs = 20
    finer_ladder: bool = False
    audio_delay_ms: Literal["auto"] | Annotated[float, Field(ge=20, le=500)] = "auto"
    player: Annotated[Literal["auto", "browser", "built-in"], BeforeValidator(_player)] = "auto"
    max_holdback_ms: _HoldbackMs = 500.0
    max_skew_ms: _SkewMs = 20.0


class OperatorSyncSettings(SyncSettings):
    """`[sync.operator]`: its own defaults, also for a file that sets only some keys."""

    least_audio_mu_ms: _MediaUnitMs = 10
    finer_ladder: bool = True
    max_holdback_ms: _HoldbackMs = 50.0
    max_skew_ms: _SkewMs = 145.0


class RoleSyncSettings(ConfigTable):
    """`[sync]`."""

    policy: Literal["by-role", "thesis"] = "by-role"
    operator: OperatorSyncSettings = OperatorSyncSettings()
    observer: SyncSettings = SyncSettings()
