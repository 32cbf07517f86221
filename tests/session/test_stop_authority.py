"""Who may press Stop, and which releases reach the latch."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Literal, cast

import pytest
from tests.turned_clock import TurnedClock

from wax.config.settings import StopSettings
from wax.control.gate import Refusal
from wax.errors import ForbiddenError
from wax.records.records import Records
from wax.session.record_keeper import RecordKeeper
from wax.session.stop_authority import ONLY_THE_OPERATOR_STOPS, StopAuthority

if TYPE_CHECKING:
    from wax.control.loop import ControlLoop
    from wax.control.stop_latch import Releaser
    from wax.control.turns import Turns
    from wax.session.viewer import Viewer

By = Literal["everybody", "operator"]
ADA = cast("Viewer", SimpleNamespace(number=1, name="Ada"))
"""She drives."""
BOB = cast("Viewer", SimpleNamespace(number=2, name="Bob"))


class Control:
    """Writes down what it is asked, and refuses as told."""

    def __init__(self) -> None:
        self.asked: list[tuple[object, ...]] = []
        self.refusal: Refusal | None = None

    def press_stop(self, by: str) -> int:
        self.asked.append((by,))
        return 7

    def release_stop(self, by: Releaser, stop: int, sent_s: float | None) -> Refusal | None:
        self.asked.append((by, stop, sent_s))
        return self.refusal


@pytest.fixture
def control() -> Control:
    return Control()


def stops(control: Control, by: By = "everybody", operator: int | None = 1) -> StopAuthority:
    turns = cast("Turns", SimpleNamespace(operator=operator))
    clock = TurnedClock()
    return StopAuthority(
        settings=StopSettings(by=by),
        turns=turns,
        control=cast("ControlLoop", control),
        keeper=RecordKeeper(records=Records(clock), clock=clock, viewers=(), refused=dict),
    )


PRESSED = {
    "the operator": ("operator", ADA, False, "Ada"),
    "the host, who watches": ("operator", BOB, True, "Bob"),
    "the host, without a page": ("operator", None, True, "the host"),
    "a watcher": ("everybody", BOB, False, "Bob"),
    "a request of nobody's": ("everybody", None, False, "somebody"),
}


@pytest.mark.parametrize(("by", "viewer", "is_host", "name"), PRESSED.values(), ids=PRESSED)
def test_pressed(control: Control, by: By, viewer: Viewer | None, is_host: bool, name: str) -> None:
    """Everybody who may stop the robot can, under the name shown to people."""
    assert stops(control, by).press(viewer, is_host=is_host) == 7
    assert control.asked == [(name,)]


@pytest.mark.parametrize("operator", [1, None])
@pytest.mark.parametrize("viewer", [BOB, None])
def test_where_only_the_operator_stops(
    control: Control, viewer: Viewer | None, operator: int | None
) -> None:
    """Others are told so, also while nobody drives."""
    with pytest.raises(ForbiddenError, match=ONLY_THE_OPERATOR_STOPS):
        stops(control, "operator", operator).press(viewer, is_host=False)
    assert control.asked == []


RELEASED = {
    "a viewer": (ADA, False, 1),
    "the host's page": (BOB, True, "host"),
    "the host, without a page": (None, True, "host"),
    "a request of nobody's": (None, False, None),
}


@pytest.mark.parametrize(("viewer", "is_host", "asker"), RELEASED.values(), ids=RELEASED)
def test_the_latch_is_asked(
    control: Control, viewer: Viewer | None, is_host: bool, asker: Releaser
) -> None:
    """The latch decides who may, and its refusal is told."""
    stops(control).release(viewer, 7, 3.5, is_host=is_host)
    assert control.asked == [(asker, 7, 3.5)]
    control.refusal = Refusal.OTHER_STOP
    with pytest.raises(ForbiddenError, match=Refusal.OTHER_STOP.value):
        stops(control).release(viewer, 7, 3.5, is_host=is_host)
