"""Asks, checks the result as the server would, and writes the file whole or not at all."""

from __future__ import annotations

import datetime
import os
import tempfile
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

from wax.capture.find_sources import make_sources
from wax.clock import SystemClock
from wax.commands.init import questions
from wax.commands.init.door import files, with_door
from wax.commands.init.found import detect
from wax.commands.init.writing import render
from wax.config import settings as config
from wax.door import line as door_line
from wax.errors import ConfigError, StateError, reason_of
from wax.logs.printable import printable
from wax.robot.find_driver import make_driver
from wax.speaker.find_speaker import make_speaker

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.commands.init.found import Found
    from wax.commands.init.questions import Key, Question
    from wax.door.line import DoorLine

_LINE_CHARS = 120


def init(
    path: Path,
    *,
    ask: Callable[[str], str] | None,
    tell: Callable[[str], None],
    port: str | None = None,
    door: str | None = None,
    detect: Callable[[], Found] = detect,
) -> None:
    """Write to `path`, which must not exist yet, a configuration that the server accepts.

    `ask` asks a person; None takes the defaults. `port` is the robot's serial port, if it is not
    listed. `door` is the line that a door printed: it is added to an existing file, which is
    otherwise unchanged. Raises `ConfigError` and `StateError`; if `ask` raises, nothing is written.
    """
    line = None if door is None else door_line.read(door)
    if line is not None and path.is_file():
        _give_door(path, line)
        tell(_next(path, is_real=False))
        return
    _check_free(path)
    found = detect()
    given: dict[Key, str] = {}
    first = questions.robot(found, port)
    given["robot"] = _answer(first, ask, tell)
    for question in questions.others(found, given["robot"].partition(" ")[0]):
        if question.key == "who" and line is not None:
            given["who"] = questions.ANYWHERE
        else:
            given[question.key] = _answer(question, ask, tell)
    if line is None and ask is not None and given["who"] == questions.ANYWHERE:
        line = _pasted(ask, tell)
    day = datetime.datetime.now().astimezone().date().isoformat()
    text = render(questions.answers(given), found, path.name, day)
    if line is not None:
        text = with_door(text, line, path)
    _check_starts(text, path)
    _keep_secrets(path, line)
    _write_new(path, text)
    tell(_next(path, is_real=given["robot"] != "simulated"))


def _next(path: Path, *, is_real: bool) -> str:
    lines = [
        f"\n{path} is written. To start the robot's server, type:\n  wax --config {path}",
        f"To check its devices and its network:\n  wax doctor --config {path}",
    ]
    if is_real:
        lines.append(
            "Before anybody drives, with its wheels off the floor, to measure how fast it stops:\n"
            f"  wax prove-stop --config {path}"
        )
    return "\n".join(lines)


def _check_free(path: Path) -> None:
    if path.exists() or path.is_symlink():
        raise ConfigError(f"{path} is there already; move it away, or give another name.")
    if not path.absolute().parent.is_dir():
        raise ConfigError(f"{path.absolute().parent} is no folder; make it first.")


def _answer(
    question: Question, ask: Callable[[str], str] | None, tell: Callable[[str], None]
) -> str:
    """Ask one question, again until the answer is valid."""
    choices = question.choices
    if ask is None:
        tell(f"{question.asks} {printable(choices[0].says, _LINE_CHARS)}")
        return choices[0].value
    tell(f"\n{question.asks}")
    for number, choice in enumerate(choices, 1):
        tell(f"  {number}  {printable(choice.says, _LINE_CHARS)}")
    while True:
        answer = ask("A number, or Enter for 1: ").strip()
        if not answer:
            return choices[0].value
        if answer.isdecimal() and 1 <= int(answer) <= len(choices):
            return choices[int(answer) - 1].value
        tell(f"Type a number from 1 to {len(choices)}.")


def _pasted(ask: Callable[[str], str], tell: Callable[[str], None]) -> DoorLine:
    """Ask for the door's line until it is valid."""
    while True:
        try:
            return door_line.read(ask("The door's line: "))
        except ConfigError as error:
            tell(str(error))


def _give_door(path: Path, line: DoorLine) -> None:
    """Add a door to an existing file, and keep a copy of the old one beside it."""
    try:
        before = path.read_text(encoding="utf-8-sig")
        text = with_door(before, line, path)
        config.parse(tomllib.loads(text), str(path))
        _keep_secrets(path, line)
        kept = path.with_name(f"{path.name}~")
        _replace(kept, before, path.stat().st_mode)
        _replace(path, text, path.stat().st_mode)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    except OSError as error:
        raise StateError(f"{path} cannot be changed: {reason_of(error)}.") from error


def _keep_secrets(path: Path, line: DoorLine | None) -> None:
    """Write the door's secrets, readable by this user only; raises `StateError`."""
    for place, text in files(line, path).items() if line is not None else ():
        try:
            _replace(place, text, 0o600)
        except OSError as error:
            raise StateError(f"{place} cannot be written: {reason_of(error)}.") from error


def _replace(path: Path, text: str, mode: int) -> None:
    """Write a file atomically, replacing any old one; raises `OSError`."""
    number, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.absolute().parent)
    try:
        with os.fdopen(number, "w", encoding="utf-8") as file:
            file.write(text)
        Path(name).chmod(mode & 0o777)
        Path(name).replace(path)
    finally:
        Path(name).unlink(missing_ok=True)


def _check_starts(text: str, path: Path) -> None:
    """Raise `ConfigError` where the server would: build the same parts, and open none."""
    settings = config.parse(tomllib.loads(text), str(path))
    clock = SystemClock()
    driver = make_driver(settings.robot, clock)
    audio = settings.audio
    if audio.source == "auto":  # "auto" may find none
        audio = audio.model_copy(update={"source": "none"})
    make_sources(settings.video, audio, clock, driver)
    make_speaker(settings.voice, clock, driver)


def _write_new(path: Path, text: str) -> None:
    """Write the file atomically, and only if there is none; raises `StateError`."""
    folder = path.absolute().parent
    try:
        number, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=folder)
        try:
            with os.fdopen(number, "w", encoding="utf-8") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            Path(name).chmod(0o644)
            _put(Path(name), path)
        finally:
            Path(name).unlink(missing_ok=True)
    except FileExistsError as error:
        raise ConfigError(
            f"{path} was made by somebody else meanwhile; it is left alone."
        ) from error
    except OSError as error:
        raise StateError(f"{path} cannot be written: {reason_of(error)}.") from error


def _put(made: Path, path: Path) -> None:
    """Rename it without replacing anything; not every file system has links."""
    try:
        path.hardlink_to(made)
    except FileExistsError:
        raise
    except OSError:
        with path.open("x", encoding="utf-8") as file:
            file.write(made.read_text(encoding="utf-8"))
