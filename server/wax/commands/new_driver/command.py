"""Writes the package of a new driver: the files of ``template`` with its name filled in."""

from __future__ import annotations

import keyword
import re
import shutil
import sys
from importlib import resources
from importlib.util import find_spec
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Final

from wax import __version__
from wax.config.robot import RobotSettings
from wax.errors import ConfigError, StartError, reason_of
from wax.plugin import DRIVERS, offers

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable
    from pathlib import Path

MAX_NAME: Final = 30
_NAME: Final = re.compile(r"[a-z][a-z0-9_]*[a-z0-9]")
_TEMPLATE: Final = "template"
_SUFFIX: Final = ".txt"
"""The suffix of each template file, so that no tool takes it for a part of WAX."""


def new_driver(name: str, parent: Path) -> list[str]:
    """Write it into the folder `name` of `parent`; return lines that say what to do next.

    Raises `ConfigError` for a name or place that cannot be used, `StartError` if writing fails;
    then nothing is left behind.
    """
    _check(name)
    folder = parent / name
    try:
        folder.mkdir()
    except FileExistsError:
        raise ConfigError(
            f"{folder} exists already; choose another name, or another folder to be in"
        ) from None
    except OSError as error:
        raise StartError(f"{folder} cannot be made: {reason_of(error)}") from error
    try:
        for path, text in _files(name):
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    except OSError as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise StartError(f"{folder} cannot be written: {reason_of(error)}") from error
    return [
        f"Written into {folder}. Its README.md leads on; in short:",
        f"  cd {folder}",
        "  pip install -e '.[test]'",
        "  pytest",
        f"  python -m {name}.stand_in   # in a second terminal: a robot made of software",
        f"  wax --config {name}.toml",
        f"Then make it yours: what is marked TODO in src/{name}, in driver.py first",
    ]


def _check(name: str) -> None:
    """Raise `ConfigError` for a name that is not a valid package name, or is taken."""
    if len(name) > MAX_NAME or not _NAME.fullmatch(name) or keyword.iskeyword(name):
        raise ConfigError(
            f"new-driver: got {name!r}; allowed are 2 to {MAX_NAME} small letters, digits and _,"
            " with a letter first, such as my_robot, and no word of Python's"
        )
    if name in RobotSettings.model_fields:
        raise ConfigError(f"new-driver: {name} is a key of [robot]; choose another name")
    taken = next((offer for offer in offers(DRIVERS) if offer.name == name), None)
    if taken is not None:
        raise ConfigError(
            f"new-driver: there is a driver {name}, which {_origin(taken.origin)}; choose another"
            " name"
        )
    if name in sys.stdlib_module_names or find_spec(name) is not None:
        raise ConfigError(
            f"new-driver: Python has a module {name} already, which yours would hide; choose"
            " another name"
        )


def _origin(origin: str) -> str:
    return origin if origin.startswith("comes") else f"is {origin}"


def _files(name: str) -> list[tuple[PurePosixPath, str]]:
    """Return each file of the package: its place and its text."""
    words = {
        "my_robot": name,
        "MyRobot": "".join(word.capitalize() for word in name.split("_")),
        "WAX_VERSION": __version__,
    }
    root = resources.files(__package__) / _TEMPLATE
    return [
        (
            PurePosixPath(_with(str(path).removesuffix(_SUFFIX), words)),
            _with(file.read_text(encoding="utf-8"), words),
        )
        for path, file in _walk(root, PurePosixPath())
    ]


def _walk(folder: Traversable, under: PurePosixPath) -> list[tuple[PurePosixPath, Traversable]]:
    found = []
    for entry in sorted(folder.iterdir(), key=lambda one: one.name):
        if entry.is_dir():
            found += _walk(entry, under / entry.name)
        elif entry.name.endswith(_SUFFIX):
            found.append((under / entry.name, entry))
    return found


def _with(text: str, words: dict[str, str]) -> str:
    for word, own in words.items():
        text = text.replace(word, own)
    return text
