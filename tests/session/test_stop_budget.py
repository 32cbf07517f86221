"""Who may press Stop, and which releases reach the latch."""

from __future__ import annotations

from contextlib import closing, suppress
from types import SimpleNamespace
from typing import TYPE_CHECKING, Literal, cast

import pytest
from tests.heard_events import Heard
from tests.turned_clock import TurnedClock
from tests.visitors import visitor

from wax.access.host_decisions import HostDecisions
from wax.config.stop import StopSettings
from wax.control.gate import Refusal
from wax.errors import ForbiddenError
from wax.records.file import open_for_reading
from wax.records.records import Records
from wax.records.writer import RecordWriter
from wax.session.record_keeper import RecordKeeper
from wax.session.stop_budget import (
    KNOWN_S,
    MUTED,
    ONLY_THE_OPERATOR_STOPS,
    TOO_OFTEN,
    StopBudget,
)

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from wax.control.stop_latch import Releaser
    from wax.sentence import Sentence
    from wax.session.parts import Parts
    from wax.session.presence import Presence
    from wax.session.viewer import Viewer

By = Literal["everybody", "operator"]
ADA = cast("Viewer", SimpleNamespace(number=1, name="Ada", visitor=visitor("ada")))
"""She drives."""
BOB = cast("Viewer", SimpleNamespace(number=2, name="Bob", visitor=visitor("bob")))


class Control:
    """Records its calls, and refuses as the test says."""

    def __init__(self) -> None:
        self.asked: list[tuple[object, ...]] = []
        self.refusal: Refusal | None = None
        self.is_pressed = False
        self.latched = None

    def would_add_nothing(self, viewer: int | None) -> bool:
        return self.is_pressed

    def press_stop(
        self, by: Sentence, *, viewer: int | None, by_host: bool, release_after_s: float
    ) -> int:
        assert release_after_s == StopSettings().release_after_s
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
    per_address: int = 5,
    clock: TurnedClock | None = None,
    decisions: HostDecisions | None = None,
    records: Records | None = None,
    since_s: Mapping[str, float] | None = None,
    heard: Heard | None = None,
) -> StopBudget:
    clock = clock or TurnedClock()
    parts = SimpleNamespace(
        settings=SimpleNamespace(
            stop=StopSettings(by=by, max_per_minute=3, max_per_minute_per_address=per_address)
        ),
        clock=clock,
        decisions=decisions or HostDecisions(),
        turns=SimpleNamespace(operator=operator),
        control=control,
        keeper=RecordKeeper(
            records=records or Records(clock),
            clock=clock,
            viewers=(),
            refused=dict,
            event_maker=(heard or Heard(clock)).event_maker,
        ),
    )
    presence = SimpleNamespace(
        watches_from=lambda address: since_s or {} if address == BOB.visitor.address else {}
    )
    return StopBudget(cast("Parts", parts), cast("Presence", presence))


PRESSED = {
    "the operator": ("operator", ADA, False, "Ada", "operator"),
    "the host, who watches": ("operator", BOB, True, "Bob", "host"),
    "the host, without a page": ("operator", None, True, "the host", "host"),
    "a watcher": ("everybody", BOB, False, "Bob", "observer"),
}


@pytest.mark.parametrize(("by", "viewer", "is_host", "name", "role"), PRESSED.values(), ids=PRESSED)
def test_pressed(
    control: Control, by: By, viewer: Viewer | None, *, is_host: bool, name: str, role: str
) -> None:
    """Everybody who may stop the robot can; people read the name, and programs are told."""
    heard = Heard(TurnedClock())
    assert stops(control, by, heard=heard).press(viewer, is_host=is_host) == 7
    own = None if viewer is None else name
    assert heard.take() == [{"type": "stop.pressed", "stop": 7, "role": role, "name": own}]
    assert [(str(by), *rest) for by, *rest in control.asked] == [
        (name, viewer and viewer.number, is_host)
    ]


@pytest.mark.parametrize("operator", [1, None])
@pytest.mark.parametrize("viewer", [BOB, None])
def test_where_only_the_operator_stops(
    control: Control, viewer: Viewer | None, operator: int | None
) -> None:
    """Others are refused with the reason, even while nobody drives."""
    with pytest.raises(ForbiddenError, match=str(ONLY_THE_OPERATOR_STOPS)):
        stops(control, "operator", operator).press(viewer, is_host=False)
    assert control.asked == []


def test_strangers_stop_nothing(control: Control) -> None:
    """Somebody who is not in the room cannot press its Stop."""
    with pytest.raises(ForbiddenError):
        stops(control).press(None, is_host=False)
    assert control.asked == []


def test_a_press_that_adds_nothing_is_free(control: Control) -> None:
    """A press that adds nothing counts against no budget, and an ignored one is still ignored."""
    clock, decisions = TurnedClock(), HostDecisions()
    budget = stops(control, clock=clock, decisions=decisions)
    control.is_pressed = True
    for _ in range(10):
        budget.press(BOB, is_host=False)
    control.is_pressed = False
    for _ in range(3):
        budget.press(BOB, is_host=False)
    with pytest.raises(ForbiddenError, match=str(TOO_OFTEN)):
        budget.press(BOB, is_host=False)
    control.is_pressed = True
    decisions.muted.add("bob")
    with pytest.raises(ForbiddenError, match=str(MUTED)):
        budget.press(BOB, is_host=False)


def test_a_repeated_press_is_the_same_press(control: Control) -> None:
    """It costs nothing, informs nobody and stops nothing anew, even after its Stop was released."""
    clock = TurnedClock()
    heard = Heard(clock)
    budget = stops(control, clock=clock, heard=heard)
    for press in range(3):
        for _ in range(10):
            assert budget.press(BOB, press, is_host=False) == 7
            clock.time_s += 1.0
        budget.release(ADA, 7, None, is_host=False)
    assert len(control.asked) == 2 * 3
    assert [one["type"] for one in heard.take()] == ["stop.pressed", "stop.released"] * 3
    assert [one.presses for one in budget.pressers()] == [3]
    with pytest.raises(ForbiddenError, match=str(TOO_OFTEN)):
        budget.press(BOB, 3, is_host=False)
    budget.press(person("eve", "198.51.100.1"), 0, is_host=False)
    assert len(control.asked) == 2 * 3 + 1, "what somebody else numbers alike is another press"


def test_a_muted_person_stops_nothing(control: Control) -> None:
    """The mute ends when they drive: the operator's own Stop always works."""
    decisions = HostDecisions(muted={"ada", "bob"})
    with pytest.raises(ForbiddenError, match=str(MUTED)):
        stops(control, decisions=decisions).press(BOB, is_host=False)
    assert stops(control, decisions=decisions).press(ADA, is_host=False) == 7


def test_a_person_has_a_budget(control: Control) -> None:
    """It refills; the operator and the host need none."""
    clock = TurnedClock()
    budget = stops(control, clock=clock)
    for _ in range(3):
        budget.press(BOB, is_host=False)
    with pytest.raises(ForbiddenError, match=str(TOO_OFTEN)):
        budget.press(BOB, is_host=False)
    for _ in range(30):
        budget.press(ADA, is_host=False)
        budget.press(BOB, is_host=True)
    clock.time_s += 60.0
    assert budget.press(BOB, is_host=False) == 7


def person(name: str, address: str = "192.0.2.1") -> Viewer:
    of = visitor(name, address=address)
    return cast("Viewer", SimpleNamespace(number=9, name=name, visitor=of))


def pressed(budget: StopBudget, *names: str) -> int:
    """Count how many of these may stop the robot, with one press each."""
    heard = 0
    for name in names:
        with suppress(ForbiddenError):
            heard += budget.press(person(name), is_host=False) == 7
    return heard


def test_new_browsers_have_no_more_than_their_address(control: Control) -> None:
    """Forty-six that press once each in 45 s have one address's budget, which refills."""
    clock = TurnedClock()
    newcomers = [f"eve{number}" for number in range(46)]
    budget = stops(control, clock=clock, since_s=dict.fromkeys(newcomers, 999.0))
    heard = 0
    for name in newcomers:
        heard += pressed(budget, name)
        clock.time_s += 45 / 46
    assert heard <= 5, "an address was heard more often than `max_per_minute_per_address`"
    clock.time_s += 60.0
    assert pressed(budget, "fay") == 1


def test_a_known_viewer_can_stop_in_a_flood(control: Control) -> None:
    """Their first press a minute counts, whatever new browsers at their address do."""
    clock = TurnedClock()
    since_s = {f"eve{number}": clock.time_s - KNOWN_S + 1 for number in range(40)}
    budget = stops(control, clock=clock, since_s={**since_s, "bob": clock.time_s - KNOWN_S})
    assert pressed(budget, *since_s) == 3
    for _ in range(3):
        assert pressed(budget, "bob") == 1
        assert pressed(budget, "bob", *since_s) <= 3
        clock.time_s += 60.0
        since_s = {f"{name}x": clock.time_s for name in since_s}


def test_few_of_an_address_are_known(control: Control) -> None:
    """Only those who have watched longest are: waiting with many browsers gains nothing."""
    clock = TurnedClock()
    since_s = {f"eve{number:02}": float(number) for number in range(40)}
    budget = stops(control, clock=clock, since_s={"bob": -1.0, **since_s})
    assert pressed(budget, *reversed(since_s)) == 3 + 1
    assert pressed(budget, "bob") == 1


def test_presses_in_vain_cost_neighbours_nothing(control: Control) -> None:
    """Somebody who hammers on Stop uses up their own budget, not all of their address's."""
    budget = stops(control, per_address=8)
    assert pressed(budget, *["eve"] * 100) == 3
    assert pressed(budget, "fay") == 1


def test_the_host_sees_who_presses_and_ignores_an_address(control: Control) -> None:
    """New browsers at the address are ignored, too; its operator's Stop still counts."""
    clock, decisions = TurnedClock(), HostDecisions()
    budget = stops(control, clock=clock, decisions=decisions)
    budget.press(ADA, is_host=False)
    assert budget.pressers() == []
    pressed(budget, "eve", "eva")
    [presser] = budget.pressers()
    assert (presser.address, str(presser.by), presser.presses) == ("192.0.2.1", "eva", 2)
    budget.mute(presser.number, True)
    with pytest.raises(ForbiddenError, match=str(MUTED)):
        budget.press(person("new"), is_host=False)
    assert budget.press(person("far", "198.51.100.1"), is_host=False) == 7
    assert budget.press(ADA, is_host=False) == 7
    clock.time_s += 3600.0
    assert [one.presses for one in budget.pressers()] == [3], "ignored, it is still told"
    budget.mute(presser.number, False)
    assert budget.pressers() == []
    assert budget.press(person("new"), is_host=False) == 7


def test_the_host_sees_a_bounded_number_of_addresses(control: Control) -> None:
    """The host is shown the newest, and all ignored ones, since only there can that be undone."""
    decisions = HostDecisions()
    budget = stops(control, decisions=decisions)
    addresses = [f"192.0.2.{number}" for number in range(100)]
    decisions.muted_addresses.update(addresses[90:99])
    for number, address in enumerate(addresses):
        with suppress(ForbiddenError):
            budget.press(person(f"eve {number}", address), is_host=False)
    told = {one.address for one in budget.pressers()}
    assert told == {*addresses[83:99], addresses[-1]}


def test_stops_are_recorded(control: Control, tmp_path: Path) -> None:
    """Each press that counts is recorded, and who released it; a refused release ends nothing."""
    clock = TurnedClock()
    records = Records(
        clock, writer=RecordWriter(tmp_path / "records.db", keep_days=30.0, clock=clock)
    )
    budget = stops(control, records=records, clock=clock)
    budget.press(ADA, is_host=False)
    control.refusal = Refusal.OTHER_STOP
    with pytest.raises(ForbiddenError):
        budget.release(BOB, 7, None, is_host=False)
    control.refusal = None
    budget.release(None, 7, None, is_host=True)
    budget.press(BOB, is_host=False)
    budget.release(ADA, 7, None, is_host=False)
    records.start()
    records.stop(10.0)
    with closing(open_for_reading(tmp_path / "records.db")) as file:
        found = file.execute("SELECT number, name, released_by FROM stops ORDER BY id").fetchall()
    assert found == [(7, "Ada", "the host"), (7, "Bob", "Ada")]


def test_where_nothing_is_stopped_a_house_releases_nothing(control: Control) -> None:
    """No Stop has the number 0, so a request that comes too early never meets the next one."""
    stops(control).release_from_house(0.5)
    ((_, number, _),) = control.asked
    assert number == 0


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
    """The latch decides who may release, and its refusal is passed on."""
    stops(control).release(viewer, 7, 3.5, is_host=is_host)
    assert control.asked == [(asker, 7, 3.5)]
    control.refusal = Refusal.OTHER_STOP
    with pytest.raises(ForbiddenError, match=str(Refusal.OTHER_STOP.value)):
        stops(control).release(viewer, 7, 3.5, is_host=is_host)
