"""Drivers' own tables: validated and shown like ours."""

from __future__ import annotations

import sys
import tomllib
from typing import TYPE_CHECKING, Any

import pytest
from tests.packages import install

from wax import plugin
from wax.__main__ import main
from wax.config import driver_tables, manual
from wax.config import settings as config
from wax.config.log import LogSettings
from wax.config.robot import RobotSettings
from wax.errors import ConfigError
from wax.robot.process.pipe_messages import Begin, decode_begin, encode

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

TANK = """
from typing import Annotated, Literal
from pydantic import BaseModel, Field, model_validator
from wax.config.driver_settings import DriverSettings


class Track(BaseModel):
    teeth: Annotated[int, Field(ge=5)] = Field(12, description="How many teeth its wheel has.")


class TankSettings(DriverSettings):
    TABLE = "tank"

    bus: Annotated[int, Field(ge=0, le=7)] = Field(1, description="The number of its bus.")
    gear: Literal["low", "high"] = "low"
    \"\"\"The gear; high is for roads.\"\"\"
    names: list[str] = Field([], description="What its tracks are called.")
    ratio: Annotated[float, Field(gt=0)] = Field(2.5, description="Turns of the motor for one.")
    track: Track = Field(Track(), description="What it runs on.")
    horn: str = Field("", pattern="^[a-g]*$", description="The notes of its horn.")

    @model_validator(mode="after")
    def _fits(self):
        if self.gear == "high" and self.bus == 0:
            raise ValueError("the bus 0 has no high gear; use another")
        if self.bus == 7:
            raise OSError("no bus")
        return self


class Tank:
    Settings = TankSettings


class Cart:
    pass


class Odd:
    Settings = {"bus": 1}


class Greedy:
    class Settings(DriverSettings):
        TABLE = "serial"
"""


@pytest.fixture(autouse=True)
def tank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Install a package with two drivers."""
    monkeypatch.syspath_prepend(str(tmp_path))
    install(
        tmp_path,
        "tank-robot",
        {plugin.DRIVERS: {"tank": "tank_drivers:Tank", "cart": "tank_drivers:Cart"}},
        modules={"tank_drivers": TANK},
    )
    yield
    sys.modules.pop("tank_drivers", None)


def problems(robot: dict[str, Any]) -> list[str]:
    """Return the problems, checked in this process."""
    return driver_tables.check_here(robot, ours=RobotSettings.model_fields)


def told(robot: dict[str, Any]) -> list[str]:
    with pytest.raises(ConfigError) as refused:
        config.parse({"robot": robot}, "robot.toml")
    heading, *lines = str(refused.value).splitlines()
    assert heading == f"robot.toml: {len(lines)} problem{'s' * (len(lines) > 1)}:"
    return [line.strip() for line in lines]


@pytest.mark.system
@pytest.mark.parametrize("driver", ["tank", "tank_drivers:Tank"])
def test_a_driver_gets_its_own_table(driver: str) -> None:
    """A driver gets its table by either name, also in another process, with its defaults."""
    tree = tomllib.loads(f"[robot]\ndriver = '{driver}'\n[robot.tank]\nbus = 3\nnames = ['a']\n")
    robot = config.parse(tree, "robot.toml").robot
    settings = plugin.load_class(driver, plugin.DRIVERS, "").Settings
    line = encode(Begin(robot=robot, log=LogSettings()))
    for one in (robot, decode_begin(line).robot):
        own = one.own(settings)
        assert (own.bus, own.names, own.gear, own.track.teeth) == (3, ["a"], "low", 12)
    assert RobotSettings().own(settings).bus == 1


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({"bus": 9}, "robot.tank.bus: got 9; allowed is a whole number from 0 to 7"),
        ({"bus": 1.0}, "robot.tank.bus: got 1.0; allowed is a whole number from 0 to 7"),
        ({"bsu": 1}, "robot.tank.bsu: there is no such key; did you mean bus?"),
        ({"gear": "top"}, 'robot.tank.gear: got "top"; allowed is "low" or "high"'),
        ({"ratio": float("inf")}, "robot.tank.ratio: got inf; allowed is a number above 0"),
        ({"names": [5]}, "robot.tank.names[0]: got 5; allowed is a text"),
        ({"track": {"teeth": 1}}, "robot.tank.track.teeth: got 1; allowed is a whole number at"),
        ({"horn": "x"}, 'robot.tank.horn: got "x"; allowed is a text like ^[a-g]*$'),
        ({"gear": "high", "bus": 0}, "robot.tank: the bus 0 has no high gear; use another"),
        ({"bus": 7}, "robot.tank: checking it failed: OSError('no bus')"),
    ],
)
def test_a_drivers_table_is_checked_like_ours(table: dict[str, Any], sentence: str) -> None:
    """Each wrong key is a line with its value and what is allowed, even if a validator fails."""
    (line,) = problems({"driver": "tank", "tank": table})
    assert line.startswith(sentence)


@pytest.mark.parametrize(
    ("robot", "sentence"),
    [
        (
            {"driver": "cart", "tank": {}},
            'robot.tank: is for driver = "tank", but driver is "cart"; leave one of them out',
        ),
        ({"tank": {}}, 'robot.tank: is for driver = "tank", but driver is "simulated"'),
        (
            {"driver": "tank", "tnak": {}},
            "robot.tnak: there is no such key; did you mean tank?",
        ),
        ({"serail": {}}, "robot.serail: there is no such key; did you mean serial?"),
        ({"driver": "nowhere:Robot", "tank": {}}, "robot.driver: nowhere:Robot: cannot import no"),
        ({"driver": "tnak", "tank": {}}, "robot.driver: got 'tnak'; possible are '"),
        ({"driver": "tank_drivers:Odd", "odd": {}}, "robot.driver: tank_drivers:Odd: its Settings"),
        (
            {"driver": "tank_drivers:Greedy", "x": {}},
            "robot.driver: tank_drivers:Greedy: its Settings have the TABLE 'serial'; give them a",
        ),
    ],
)
def test_a_table_of_nobody_is_refused(robot: dict[str, Any], sentence: str) -> None:
    """A table that no driver reads is refused with a sentence."""
    (line,) = problems(robot)
    assert line.startswith(sentence)


@pytest.mark.system
def test_their_problems_are_told_beside_ours() -> None:
    """One message has the problems of drivers' tables and of our keys."""
    lines = told({"driver": "tank", "tank": {"bus": 9}, "silence_ms": 1, "serial": {"baud": 1}})
    assert sorted(line.partition(":")[0] for line in lines) == [
        "robot.serial.baud",
        "robot.silence_ms",
        "robot.tank.bus",
    ]


def test_what_is_no_table_is_no_key() -> None:
    """A value in place of a driver's table is an unknown key."""
    assert told({"tank": 5}) == ["robot.tank: there is no such key"]


ODD = {"driver": "odd_driver:Robot", "odd": {}}


@pytest.mark.system
@pytest.mark.parametrize("text", ["raise OSError('no bus')", "import os\nos._exit(0)"])
def test_a_class_that_fails_while_it_is_loaded_ends_nobody(text: str, tmp_path: Path) -> None:
    """A class that fails while it loads does so in another process, and is no mistake here."""
    (tmp_path / "odd_driver.py").write_text(text)
    assert config.parse({"robot": ODD}, "robot.toml").robot.own_tables == {"odd": {}}
    assert "odd_driver" not in sys.modules


@pytest.mark.system
@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("print('[\"no\"]')", "odd_driver has no class Robot"),
        ("import nothing", "cannot import odd_driver: No module named 'nothing'"),
    ],
)
def test_a_class_that_is_not_there_is_a_mistake(text: str, sentence: str, tmp_path: Path) -> None:
    """A missing class is a mistake, whatever its module prints."""
    (tmp_path / "odd_driver.py").write_text(text)
    (line,) = told(ODD)
    assert line == f"robot.driver: odd_driver:Robot: {sentence}"


@pytest.mark.system
def test_the_tables_are_shown_with_reasons_and_ranges(capsys: pytest.CaptureFixture[str]) -> None:
    """`wax config` writes TOML that loads, with each key's reason, range and default."""
    assert main(["config", "tank"]) == 0
    shown = capsys.readouterr().out
    assert "# The number of its bus.\n# Allowed: a whole number from 0 to 7\nbus = 1\n" in shown
    assert '# The gear; high is for roads.\n# Allowed: "low" or "high"\ngear = "low"\n' in shown
    assert "# What it runs on.\n[robot.tank.track]\n# How many teeth its wheel has.\n" in shown
    tree = {"robot": {"driver": "tank"} | tomllib.loads(shown)["robot"]}
    assert (
        config.parse(tree, "shown").robot.own(
            plugin.load_class("tank", plugin.DRIVERS, "").Settings
        )
        == plugin.load_class("tank", plugin.DRIVERS, "").Settings()
    )
    assert main(["config"]) == 0
    shown = capsys.readouterr().out
    assert "[robot.tank]\n" in shown
    assert "# serial: [robot.serial] is in the manual." in shown
    assert "# cart: has no keys of its own." in shown
    assert main(["config", "tnak"]) == 2
    assert "got 'tnak'" in capsys.readouterr().err


def test_a_driver_that_cannot_be_loaded_hides_no_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`wax config` has a line for a driver that cannot be loaded, and shows the others."""
    install(tmp_path, "boat-robot", {plugin.DRIVERS: {"boat": "no_boat:Boat"}})
    assert main(["config"]) == 0
    shown = capsys.readouterr().out
    assert "# robot.driver: boat: cannot import no_boat: No module" in shown
    assert "[robot.tank]\n" in shown


OURS = [offer.name for offer in plugin.offers(plugin.DRIVERS) if offer.is_ours]


@pytest.mark.parametrize("name", OURS)
def test_every_table_of_ours_is_explained(name: str) -> None:
    """Each of our tables has its driver's name, a purpose for each key, and valid defaults."""
    fields = RobotSettings.model_fields
    model = driver_tables.model_of(plugin.load_class(name, plugin.DRIVERS, ""), name, fields)
    if model is None:
        return
    assert name == model.TABLE
    assert config.parse({"robot": {name: model().model_dump(mode="json")}}, "x")
    for key, text in manual.purposes(model).items():
        assert len(text.split()) >= 2, key
