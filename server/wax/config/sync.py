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
    """How everybody but the operator hears and sees."""

    policy: Literal["audio-master", "video-first"] = "audio-master"
    """Which stream waits: "audio-master" holds the picture back until its sound is heard;
    "video-first" never does."""
    audio_mu_ms: Literal["auto", 10, 20, 40, 60, 120] = "auto"
    """Milliseconds of sound in one packet, one of [audio] encodings. Longer packets save headers on
    a slow link but add their length to the delay; "auto" lets each viewer's link decide."""
    least_audio_mu_ms: _MediaUnitMs = 20
    """The shortest packet that "auto" may choose, in milliseconds. 10 is heard 10 ms sooner than 20
    but needs twice as many packets, too many for a crowd of observers."""
    finer_ladder: bool = False
    """A finer ladder: one more step between two of [video] renditions, encoded for this viewer
    alone if half of the machine's cores can do it."""
    audio_delay_ms: Literal["auto"] | Annotated[float, Field(ge=20, le=500)] = "auto"
    """Milliseconds of delay for the sound in the browser's jitter buffer and the viewer's device;
    "auto" adapts to the least that plays without gaps on their link."""
    player: Annotated[Literal["auto", "browser", "built-in"], BeforeValidator(_player)] = "auto"
    """What plays the sound on the page: "browser" is the browser's own player, "built-in" is WAX's,
    which is heard sooner; it needs HTTPS (or localhost) and a browser with AudioDecoder. "auto"
    is WAX's where it can play, else the browser's. Viewers may choose on their page."""
    max_holdback_ms: _HoldbackMs = 500.0
    """The most milliseconds by which the picture is held back to match its sound. Observers do not
    mind: half a second is the thesis's value."""
    max_skew_ms: _SkewMs = 20.0
    """Tolerated skew between sound and picture in milliseconds; nobody notices 20."""


class OperatorSyncSettings(SyncSettings):
    """The operator has separate limits, because a late picture is worse for driving than one out of
    sync.
    """

    least_audio_mu_ms: _MediaUnitMs = 10
    """The shortest packet that "auto" may choose, in milliseconds. 10 is heard 10 ms sooner than 20
    but needs twice as many packets, which is affordable for one viewer."""
    finer_ladder: bool = True
    """A finer ladder: one more step between two of [video] renditions, encoded for this viewer
    alone if half of the machine's cores can do it."""
    max_holdback_ms: _HoldbackMs = 50.0
    """The most milliseconds by which the picture is held back to match its sound; beyond that it is
    shown, in sync or not. 50 is little compared with human reaction time."""
    max_skew_ms: _SkewMs = 145.0
    """Tolerated skew between sound and picture in milliseconds, of which 20 are what single
    measurements vary: sound up to 125 late goes unnoticed (ITU-R BT.1359), so the picture does
    not wait for it."""


class RoleSyncSettings(ConfigTable):
    """The sound is the master and the picture follows it, because people notice every gap in the
    sound.
    """

    policy: Literal["by-role", "thesis"] = "by-role"
    """How viewers are served: "by-role" uses the two tables below. "thesis" serves everybody like
    the system of 2004: telephone sound in units of half a second and ten small pictures a second,
    as set in [thesis]. It is the baseline for comparing WAX (config/thesis.toml), and no better for
    anybody."""
    operator: OperatorSyncSettings = OperatorSyncSettings()
    observer: SyncSettings = SyncSettings()
