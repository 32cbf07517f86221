"""Plug-ins by the names of their packages' entry points."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from tests.packages import install

from wax import plugin
from wax.errors import ConfigError
from wax.plugin import CAMERAS, DRIVERS, MICROPHONES

if TYPE_CHECKING:
    from collections.abc import Iterator

KEY = "robot.driver"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder on Python's module search path."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name in set(sys.modules) - before:
        del sys.modules[name]


def test_what_comes_with_wax_is_offered_as_the_project_says() -> None:
    """The installed package has the project's entry points, and each is a class."""
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    for group in (DRIVERS, CAMERAS, MICROPHONES):
        ours = {offer.name: offer.value for offer in plugin.offers(group) if offer.is_ours}
        assert ours == project["entry-points"][group]
        for name in ours:
            assert isinstance(plugin.load_class(name, group, KEY), type)


def test_a_package_of_somebody_else_is_found_by_its_name(folder: Path) -> None:
    """A foreign class is loaded by its name alone, and listed with its package."""
    install(
        folder,
        "tank-robot",
        {DRIVERS: {"tank": "tank_module:Tank"}, CAMERAS: {"periscope": "tank_module:Tank"}},
        modules={"tank_module": "class Tank: pass"},
    )
    assert plugin.load_class("tank", DRIVERS, KEY).__name__ == "Tank"
    assert plugin.is_plugin("periscope", CAMERAS, KEY)
    assert not plugin.is_plugin("periscope", MICROPHONES, KEY)
    listed = "\n".join(plugin.list_plugins())
    assert '[robot] driver = "tank"   # of tank-robot 1.2\n' in listed
    assert '[video] source = "periscope"   # of tank-robot 1.2\n' in listed
    assert '[robot] driver = "serial"   # comes with WAX\n' in listed


def test_an_unknown_name_is_told_what_there_is(folder: Path) -> None:
    """An unknown name is refused with the possible ones, other packages' included."""
    install(folder, "tank-robot", {DRIVERS: {"tank": "tank_module:Tank"}})
    with pytest.raises(ConfigError) as refused:
        plugin.load_class("tnak", DRIVERS, KEY)
    assert str(refused.value) == (
        "robot.driver: got 'tnak'; possible are "
        + ", ".join(repr(offer.name) for offer in plugin.offers(DRIVERS))
        + ", or your own class as 'package.module:Class'"
    )
    assert "'tank'" in str(refused.value)


def test_ours_cannot_be_replaced(folder: Path) -> None:
    """A package cannot take over a name of WAX's own."""
    install(folder, "tank-robot", {DRIVERS: {"serial": "tank_module:Tank"}})
    offer = plugin.find_offer("serial", DRIVERS, KEY)
    assert offer is not None
    assert offer.is_ours


def test_a_name_that_two_packages_offer_is_nobodys(folder: Path) -> None:
    """A name that two packages offer is refused with how to write the one that is meant."""
    install(folder, "tank-robot", {DRIVERS: {"tank": "tank_module:Tank"}})
    install(folder, "water-works", {DRIVERS: {"tank": "water:Tank"}})
    with pytest.raises(ConfigError) as refused:
        plugin.load_class("tank", DRIVERS, KEY)
    assert str(refused.value) == (
        "robot.driver: tank is offered by tank-robot as 'tank_module:Tank' and water-works as"
        " 'water:Tank'; write which of them you mean."
    )


LAZY = """
class Tank:
    def __init__(self, settings, clock):
        import tank_bus
    def open(self): pass
"""


@pytest.mark.parametrize("text", ["import tank_bus\nclass Tank: pass", LAZY])
def test_a_missing_extra_is_told_with_the_line_that_installs_it(folder: Path, text: str) -> None:
    """A missing library is a sentence with the command that installs it, as in `wax devices`."""
    install(
        folder,
        "tank-robot",
        {DRIVERS: {"tank": "tank_module:Tank"}},
        modules={"tank_module": text},
        needs={"tank": "tank-bus"},
    )
    line = 'pip install "tank-robot[tank]"'
    assert f'"tank"   # of tank-robot 1.2; to have it: {line}' in "\n".join(plugin.list_plugins())
    said = f"robot.driver: tank needs tank_bus, which is not installed: {line}"
    with pytest.raises(ConfigError, match=f"^{re.escape(said)}$"):
        plugin.make_plugin(
            "tank", KEY, None, None, needs=["open"] * (text == LAZY), contract="x", group=DRIVERS
        )
    install(folder, "tank-bus", {})
    assert "to have it" not in "\n".join(line for line in plugin.list_plugins() if '"tank"' in line)


def test_a_broken_offer_is_told_apart_from_a_missing_extra(folder: Path) -> None:
    """An entry point that leads nowhere is reported as broken, not as a missing extra."""
    install(folder, "tank-robot", {DRIVERS: {"tank": "tank_module:Tank"}})
    with pytest.raises(ConfigError, match=r"^robot\.driver: tank: cannot import tank_module: No"):
        plugin.load_class("tank", DRIVERS, KEY)
