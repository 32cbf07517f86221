"""A viewer who is served, as those who write records and tapes see them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

from tests.visitors import visitor

from wax.error_boundary import ErrorBoundary
from wax.streams.interface import StreamState
from wax.telemetry import Counters

if TYPE_CHECKING:
    from wax.session.viewer import Viewer


def served_viewer(number: int, name: str, *, streams: object = None, ready: bool = True) -> Viewer:
    """Make a viewer 40 ms away, of whose packets 1 % are lost; Hedy is the host."""
    report = SimpleNamespace(
        sound=SimpleNamespace(age_ms=120.0, delay_ms=40.0),
        picture=SimpleNamespace(age_ms=90.0, delay_ms=None),
    )
    figures = dict.fromkeys(("picture_hz", "sound_mu_ms", "link_bps", "queue_ms"))
    served = SimpleNamespace(rendition="640x480", reason="All is sent.", **figures)
    state = StreamState({}, cast("Any", served), lost=0.01)
    made = SimpleNamespace(
        number=number,
        visitor=visitor(f"{name}-11111111", address="192.0.2.7", is_host=name == "Hedy"),
        name=name,
        is_ready=ready,
        was_ready=ready,
        link=SimpleNamespace(newest_s=0.04, one_way_s=0.02),
        report=report,
        streams=streams or SimpleNamespace(status=lambda: state),
        boundary=ErrorBoundary(viewer=number, counters=Counters(), end=lambda: None),
    )
    return cast("Viewer", made)
