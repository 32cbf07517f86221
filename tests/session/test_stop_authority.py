"""Who may press Stop, and which releases reach the latch."""

from __future__ import annotations

from contextlib import closing
from types import SimpleNamespace
from typing import TYPE_CHECKING, Literal, cast

import pytest
from tests.turned_clock import TurnedClock
from tests.visitors import visitor

from wax.config.settings import StopSettings
from wax.control.gate import Refusal
from wax.errors import ForbiddenError
from wax.records.file import open_for_reading
from wax.records.records import Records
from wax.records.writer import RecordWriter
from wax.session.house import House
from wax.session.record_keeper import RecordKeeper
from wax.session.stop_authority import (
    MUTED,
    ONLY_THE_OPERATOR_STOPS,
    TOO_OFTEN,
    StopAuthority,
)

if TYPE_CHECKING:
    from pathlib import Path

    from wax.control.loop import ControlLoop
    from wax.control.stop_latch import Releaser
    from wax.control.turns import Turns
    from wax.sentence import Sentence
    from wax.session.viewer import Viewer

By = Literal["everybody", "operator"]
ADA = cast("Viewer", SimpleNamespace(number=1, name="Ada", visitor=visitor("ada")))
"""She drives."""
BOB = cast("Viewer", SimpleNamespace(number=2, name="Bob", visitor=visitor("bob")))


class Control:
    """Writes down what it is asked, and refuses as told."""

    def __init__(self) -> None:
        self.asked: list[tuple[object, ...]] = []
        self.refusal: Refusal | None = None

    def press_stop(self, by: Sentence, *, viewer: int | None, by_host: bool) -> int:
        self.asked.append((by, viewer, by_host))
        return 7

    def release_stop(self, by: Releaser, stop: int, sent_s: float | None) -> Refusal | None:
        self.asked.append((by, stop, sent_s))
        return self.refusal


@pytest.fixture
def control() -> Control:
    return Control()


def stops(
    control: Control,
    by: By = "everybody",
    operator: int | None = 1,
    *,
    clock: TurnedClock | None = None,
    house: House | None = None,
    records: Records | None = None,
) -> StopAuthority:
    turns = cast("Turns", SimpleNamespace(operator=operator))
    clock = clock or TurnedClock()
    return StopAuthority(
        settings=StopSettings(by=by, max_per_minute=3, max_per_minute_per_address=5),
        clock=clock,
        house=house or House(),
        turns=turns,
        control=cast("ControlLoop", control),
        keeper=RecordKeeper(
            records=records or Records(clock), clock=clock, viewers=(), refused=dict
        ),
    )


PRESSED = {
    "the operator": ("operator", ADA, False, "Ada"),
    "the host, who watches": ("operator", BOB, True, "Bob"),
    "the host, without a page": ("operator", None, True, "the host"),
    "a watcher": ("everybody", BOB, False, "Bob"),
}


@pytest.mark.parametrize(("by", "viewer", "is_host", "name"), PRESSED.values(), ids=PRESSED)
def test_pressed(control: Control, by: By, viewer: Viewer | None, is_host: bool, name: str) -> None:
    """Everybody who may stop the robot can, under the name shown to people."""
    assert stops(control, by).press(viewer, is_host=is_host) == 7
    assert [(str(by), *rest) for by, *rest in control.asked] == [
        (name, viewer and viewer.number, is_host)
    ]


@pytest.mark.parametrize("operator", [1, None])
@pytest.mark.parametrize("viewer", [BOB, None])
def test_where_only_the_operator_stops(
    control: Control, viewer: Viewer | None, operator: int | None
) -> None:
    """Others are told so, also while nobody drives."""
    with pytest.raises(ForbiddenError, match=str(ONLY_THE_OPERATOR_STOPS)):
        stops(control, "operator", operator).press(viewer, is_host=False)
    assert control.asked == []


def test_unknown_people_stop_nothing(control: Control) -> None:
    """Who is not in the room cannot press its Stop."""
    with pytest.raises(ForbiddenError):
        stops(control).press(None, is_host=False)
    assert control.asked == []


def test_who_is_muted_stops_nothing(control: Control) -> None:
    """Until they drive: the operator's own Stop always works."""
    house = House(muted={"ada", "bob"})
    with pytest.raises(ForbiddenError, match=str(MUTED)):
        stops(control, house=house).press(BOB, is_host=False)
    assert stops(control, house=house).press(ADA, is_host=False) == 7


def test_a_person_has_a_budget(control: Control) -> None:
    """It fills again; the operator and the host have no need of one."""
    clock = TurnedClock()
    authority = stops(control, clock=clock)
    for _ in range(3):
        authority.press(BOB, is_host=False)
    with pytest.raises(ForbiddenError, match=str(TOO_OFTEN)):
        authority.press(BOB, is_host=False)
    for _ in range(30):
        authority.press(ADA, is_host=False)
        authority.press(BOB, is_host=True)
    clock.time_s += 60.0
    assert authority.press(BOB, is_host=False) == 7


def test_the_first_press_of_everybody_counts(control: Control) -> None:
    """Also where the others of their address have used up what it has; their second does not."""
    authority = stops(control)
    for number in range(10, 20):
        eve = cast(
            "Viewer", SimpleNamespace(number=number, name="Eve", visitor=visitor(f"eve{number}"))
        )
        assert authority.press(eve, is_host=False) == 7
        if number > 15:
            with pytest.raises(ForbiddenError, match=str(TOO_OFTEN)):
                authority.press(eve, is_host=False)


def test_stops_are_recorded(control: Control, tmp_path: Path) -> None:
    """Each press that counts, and who released it; a refused release ends nothing."""
    clock = TurnedClock()
    records = Records(
        clock, writer=RecordWriter(tmp_path / "records.db", keep_days=30.0, clock=clock)
    )
    authority = stops(control, records=records, clock=clock)
    authority.press(ADA, is_host=False)
    control.refusal = Refusal.OTHER_STOP
    with pytest.raises(ForbiddenError):
        authority.release(BOB, 7, None, is_host=False)
    control.refusal = None
    authority.release(None, 7, None, is_host=True)
    authority.press(BOB, is_host=False)
    authority.release(ADA, 7, None, is_host=False)
    records.start()
    records.stop(10.0)
    with closing(open_for_reading(tmp_path / "records.db")) as file:
        found = file.execute("SELECT number, name, released_by FROM stops ORDER BY id").fetchall()
    assert found == [(7, "Ada", "the host"), (7, "Bob", "Ada")]


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
    with pytest.raises(ForbiddenError, match=str(Refusal.OTHER_STOP.value)):
        stops(control).release(viewer, 7, 3.5, is_host=is_host)
