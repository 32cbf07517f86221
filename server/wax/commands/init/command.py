"""Ask, check the answer as the server would, and write the file whole or not at all."""

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
from wax.commands.init.found import look
from wax.commands.init.writing import render
from wax.config import settings as config
from wax.errors import ConfigError, StateError
from wax.logs.printable import printable
from wax.robot.find_driver import make_driver
from wax.speaker.find_speaker import make_speaker

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.commands.init.found import Found
    from wax.commands.init.questions import Key, Question

_LINE_CHARS = 120


def init(
    path: Path,
    *,
    ask: Callable[[str], str] | None,
    tell: Callable[[str], None],
    port: str | None = None,
    look: Callable[[], Found] = look,
) -> None:
    """Write a configuration that starts to `path`, which must not exist yet.

    `ask` puts a question to a person; None takes the defaults. `port` is the robot's serial port,
    where it is not among those that are listed. Raises `ConfigError` and `StateError`; whatever
    `ask` raises ends it, and nothing is written then.
    """
    _check_free(path)
    found = look()
    given: dict[Key, str] = {}
    first = questions.robot(found, port)
    given["robot"] = _answer(first, ask, tell)
    for question in questions.others(found, given["robot"].partition(" ")[0]):
        given[question.key] = _answer(question, ask, tell)
    day = datetime.datetime.now().astimezone().date().isoformat()
    text = render(questions.answers(given), found, path.name, day)
    _check_starts(text, path)
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
    """Put one question; an answer that is none is asked for again."""
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


def _check_starts(text: str, path: Path) -> None:
    """Raise `ConfigError` where the server would: it builds the same, and opens nothing."""
    settings = config.parse(tomllib.loads(text), str(path))
    clock = SystemClock()
    driver = make_driver(settings.robot, clock)
    audio = settings.audio
    if audio.source == "auto":  # starts with a microphone and without
        audio = audio.model_copy(update={"source": "none"})
    make_sources(settings.video, audio, clock, driver)
    make_speaker(settings.voice, clock, driver)


def _write_new(path: Path, text: str) -> None:
    """Write the file whole, and only if there is none; raises `StateError`."""
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
        raise StateError(f"{path} cannot be written: {error.strerror or error}.") from error


def _put(made: Path, path: Path) -> None:
    """Give it its name without replacing anything; not every file system has links."""
    try:
        path.hardlink_to(made)
    except FileExistsError:
        raise
    except OSError:
        with path.open("x", encoding="utf-8") as file:
            file.write(made.read_text(encoding="utf-8"))
