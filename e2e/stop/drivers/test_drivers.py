"""The drivers' suite, short: each robot is driven and stops, and the measures can fail."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

import pytest

from e2e.harness.missing import missing
from e2e.measure.errors import NotRunError
from e2e.stop.drivers.gone import driver_killed, link_cut
from e2e.stop.drivers.key_to_wire import key_to_wire
from e2e.stop.drivers.robots import KINDS
from e2e.stop.drivers.suite import check_needs
from e2e.stop.server_gone import server_killed, server_stopped
from e2e.stop.stage import LIGHT

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.stop.drivers.robots import Kind

TRIALS = 2
BRIEF = {"ros2"}
"""What `make test` asks as well."""
pytestmark = pytest.mark.timeout(120)


@pytest.fixture
def kind(request: pytest.FixtureRequest) -> Kind:
    """Give the driver, if its robot can be here."""
    kind: Kind = request.param
    try:
        check_needs(kind)
    except NotRunError as error:
        missing(str(error))
    return kind


def kinds(*, linked: bool = False, brief: bool = False) -> list[object]:
    """Parametrize by driver."""
    return [
        pytest.param(
            kind,
            id=kind.key,
            marks=[] if brief and kind.key in BRIEF else [pytest.mark.full],
        )
        for kind in KINDS
        if kind.has_link or not linked
    ]


def keeps(row: Row) -> None:
    assert row.n == TRIALS
    assert row.met, row


@pytest.mark.parametrize("kind", kinds(brief=True), indirect=True)
async def test_a_frozen_server_stops_each_robot(kind: Kind) -> None:
    """Told by the driver's process within 200 ms, and nothing late moves it."""
    keeps(await server_stopped(TRIALS, end=kind.robot, load=LIGHT))


@pytest.mark.parametrize("kind", kinds(), indirect=True)
async def test_a_dead_server_stops_each_robot(kind: Kind) -> None:
    """The same, and the next server drives it."""
    keeps(await server_killed(TRIALS, end=kind.robot, load=LIGHT))


@pytest.mark.parametrize("kind", kinds(linked=True), indirect=True)
async def test_a_dead_driver_stops_each_robot(kind: Kind) -> None:
    """By a standby, or by itself as it promises."""
    keeps(await driver_killed(kind, TRIALS, load=LIGHT))


@pytest.mark.parametrize("kind", kinds(linked=True), indirect=True)
async def test_a_frozen_driver_stops_each_robot(kind: Kind) -> None:
    """The same, and the server replaces it."""
    keeps(await driver_killed(kind, TRIALS, by=signal.SIGSTOP, load=LIGHT))


@pytest.mark.full
async def test_without_a_standby_a_dead_driver_is_late() -> None:
    """The measure of a dead driver can fail."""
    (kind,) = (one for one in KINDS if one.key == "ros2")
    assert not (await driver_killed(kind, 1, robot={"ros2": {"standby": False}}, load=LIGHT)).met


@pytest.mark.parametrize("kind", kinds(linked=True), indirect=True)
async def test_a_mended_link_moves_nothing(kind: Kind) -> None:
    """However long the control has been held."""
    keeps(await link_cut(kind, TRIALS, load=LIGHT))


@pytest.mark.parametrize("kind", kinds(), indirect=True)
async def test_a_key_is_seen_on_each_wire(kind: Kind) -> None:
    """Every press, and every release."""
    row = await key_to_wire(kind, 8)
    assert row.n >= 7
    assert row.detail["released"] >= 7
    assert row.spread is not None
    assert -1 < row.spread.min < 500
