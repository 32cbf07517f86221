"""`wax new-driver` writes a whole package, or nothing and a sentence."""

from __future__ import annotations

import importlib
import sys
import tomllib
from typing import TYPE_CHECKING

import pytest
from tests.until import until

from wax import __main__
from wax.clock import SystemClock
from wax.commands.new_driver.command import MAX_NAME, new_driver
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.build_driver import make_driver

if TYPE_CHECKING:
    from pathlib import Path


def texts(folder: Path) -> dict[str, str]:
    files = [path for path in folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(folder)): path.read_text(encoding="utf-8") for path in files}


def test_it_writes_a_package_of_that_name(tmp_path: Path) -> None:
    """All files are there under the driver's own name; nothing of the template's is left."""
    lines = new_driver("garden_rover", tmp_path)
    found = texts(tmp_path / "garden_rover")
    assert set(found) == {
        "README.md",
        "garden_rover.toml",
        "pyproject.toml",
        "src/garden_rover/__init__.py",
        "src/garden_rover/driver.py",
        "src/garden_rover/py.typed",
        "src/garden_rover/settings.py",
        "src/garden_rover/stand_in.py",
        "tests/test_driver.py",
    }
    whole = "\n".join([*found, *found.values(), *lines])
    assert not [word for word in ("my_robot", "MyRobot", "WAX_VERSION", ".txt") if word in whole]
    project = tomllib.loads(found["pyproject.toml"])["project"]
    points = project["entry-points"]["wax.drivers"]
    assert points == {"garden_rover": "garden_rover.driver:GardenRover"}
    assert "class GardenRover(SteadyRobot):" in found["src/garden_rover/driver.py"]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Rover", "small letters"),
        ("r", "2 to 30"),
        ("x" * (MAX_NAME + 1), "2 to 30"),
        ("my-rover", "small letters"),
        ("../rover", "small letters"),
        ("rover_", "small letters"),
        ("", "small letters"),
        ("röver", "small letters"),
        ("while", "no word of Python's"),
        ("silence_ms", "is a key of [robot]"),
        ("serial", "choose another name"),
        ("simulated", "there is a driver simulated, which comes with WAX"),
        ("json", "Python has a module json already"),
        ("numpy", "Python has a module numpy already"),
        ("wax", "Python has a module wax already"),
    ],
)
def test_a_name_that_cannot_be_used_is_refused(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    words: str,
) -> None:
    """It says in one sentence what is wrong with the name, and writes nothing."""
    monkeypatch.chdir(tmp_path)
    assert __main__.main(["new-driver", name]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert words in complaint
    assert not list(tmp_path.iterdir())


def test_what_is_there_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder or file of that name is refused and not touched."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rover").mkdir()
    (tmp_path / "tank").write_text("mine", encoding="utf-8")
    for name in ("rover", "tank"):
        assert __main__.main(["new-driver", name]) == 2
        assert f"{name} exists already" in capsys.readouterr().err
    assert not list((tmp_path / "rover").iterdir())
    assert (tmp_path / "tank").read_text(encoding="utf-8") == "mine"


def test_where_nothing_can_be_written_nothing_is_left(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that is full half-way is a sentence, and no half of a package."""
    monkeypatch.chdir(tmp_path)
    written: list[Path] = []

    def full(path: Path, text: str, encoding: str) -> None:
        if len(written) == 3:
            raise OSError(28, "No space left on device")
        written.append(path)
        path.write_bytes(text.encode(encoding))

    monkeypatch.setattr("pathlib.Path.write_text", full)
    assert __main__.main(["new-driver", "rover"]) == 1
    assert capsys.readouterr().err == "wax: rover cannot be written: No space left on device\n"
    assert not list(tmp_path.iterdir())


def test_the_command_says_how_to_go_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each next command is printed."""
    monkeypatch.chdir(tmp_path)
    assert __main__.main(["new-driver", "rover"]) == 0
    said = capsys.readouterr().out
    for command in ("cd rover", "pip install -e", "pytest", "wax --config rover.toml"):
        assert f"\n  {command}" in said


def test_three_lines_make_it_move_sideways(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the lines that its README names, the stand-in is told a speed to the left."""
    new_driver("crab", tmp_path)
    folder = tmp_path / "crab"
    said = (folder / "README.md").read_text(encoding="utf-8")
    aside = " {twist.lateral_mps:.3f}"
    for line in ("`moves_sideways = True`", f"`{aside}`", "`max_lateral_mps = 0.6`"):
        assert line in said
    path = folder / "src/crab/driver.py"
    text = path.read_text(encoding="utf-8")
    text = text.replace("moves_sideways = False", "moves_sideways = True")
    path.write_text(text.replace(r".3f}\n", rf".3f}}{aside}\n"), encoding="utf-8")
    monkeypatch.syspath_prepend(str(folder / "src"))
    robot = importlib.import_module("crab.stand_in").StandIn()
    robot.start()
    table = {"crab": {"port": robot.port}, "max_lateral_mps": 0.6}
    settings = RobotSettings.model_validate({"driver": "crab.driver:Crab", **table})
    driver = make_driver(settings, SystemClock())
    try:
        assert driver.limits.lateral_mps == 0.6
        driver.open()
        until(lambda: driver.state().connected)

        def is_told() -> bool:
            driver.apply(Twist(0.1, 0.2, 0.3), 1)
            return bool(robot.moves == Twist(0.1, 0.2, 0.3))

        driver.apply(STANDSTILL, 1)
        until(is_told)
    finally:
        driver.close()
        robot.stop()
        for name in ("crab", "crab.driver", "crab.settings", "crab.stand_in"):
            sys.modules.pop(name, None)
