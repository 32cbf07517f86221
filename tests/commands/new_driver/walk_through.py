"""The walk-through as it is written: its commands, its lines of Python, and an environment."""

from __future__ import annotations

import os
import re
import shlex
import site
import subprocess
import venv
from pathlib import Path
from typing import TYPE_CHECKING, Final

import wax

if TYPE_CHECKING:
    from collections.abc import Sequence

_TEXT: Final = (Path(wax.__file__).parent / "commands/new_driver/README.md").read_text(
    encoding="utf-8"
)
_BLOCK: Final = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_AS_IT_IS: Final = re.compile(r"\Aclass .*\n    \.\.\..*\n\n")
_TODO: Final = "    # TODO"
_OFFLINE: Final = ("--no-deps", "--no-build-isolation", "--no-index")


def commands() -> list[list[str]]:
    """Return the commands to type, block by block."""
    return [text.splitlines() for language, text in _BLOCK.findall(_TEXT) if not language]


def own_lines() -> list[str]:
    """Return the lines of the host's own: those of the table, those of the driver."""
    return [_AS_IT_IS.sub("", text) for language, text in _BLOCK.findall(_TEXT) if language]


class Environment:
    """A virtual environment that has what this one has, and a folder in which one works."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        venv.create(folder / "venv", symlinks=True)
        self.python = folder / "venv/bin/python"
        packages = next((folder / "venv/lib").glob("python*")) / "site-packages"
        shared = [*site.getsitepackages(), str(Path(wax.__file__).parents[1])]
        (packages / "shared.pth").write_text("\n".join(shared), encoding="utf-8")

    def command(self, line: str, *more: str) -> list[str]:
        """Return what typing this line runs; nothing is asked of the network."""
        program, *words = shlex.split(line)
        match program:
            case "pip":
                module, more = "pip", (*_OFFLINE, "--quiet", *more)
            case "python":
                return [str(self.python), *words, *more]
            case "pytest" | "ruff" | "mypy" | "wax":
                module = program
            case _:
                raise ValueError(f"the walk-through does not teach {program}")
        return [str(self.python), "-m", module, *words, *more]

    def type(self, line: str, *more: str) -> str:
        """Run it to its end in the folder; return what it prints. It must succeed."""
        if line.startswith("cd "):
            self.folder /= line.removeprefix("cd ")
            return ""
        run = subprocess.run(
            self.command(line, *more),
            cwd=self.folder,
            env=environment(),
            check=False,
            capture_output=True,
            text=True,
        )
        assert run.returncode == 0, f"{line}\n{run.stdout}\n{run.stderr}"
        return run.stdout

    def start(self, line: str, *more: str) -> subprocess.Popen[str]:
        """Run it in the background; its output can be read."""
        return subprocess.Popen(
            self.command(line, *more),
            cwd=self.folder,
            env=environment(),
            stdout=subprocess.PIPE,
            text=True,
        )


def environment() -> dict[str, str]:
    """Return the variables of somebody at a terminal, not of the tests that run here."""
    ours = ("PYTEST_", "COV_", "COVERAGE_", "PYTHONPATH", "VIRTUAL_ENV")
    return {name: value for name, value in os.environ.items() if not name.startswith(ours)}


def with_own_lines(folder: Path) -> None:
    """Do in the package of `folder` what the walk-through says under "Your own lines"."""
    table, driver = own_lines()
    _below_todo(folder / "src/rover/settings.py", table)
    _below_todo(folder / "src/rover/driver.py", driver)
    path = folder / "src/rover/driver.py"
    text = path.read_text(encoding="utf-8")
    text = text.replace("import contextlib\nimport socket\n", "import contextlib\nimport json\n")
    text = text.replace("TYPE_CHECKING\n\nfrom wax", "TYPE_CHECKING\n\nimport serial\nfrom wax")
    assert "import json" in text
    assert "import serial" in text
    path.write_text(text, encoding="utf-8")


def _below_todo(path: Path, lines: str) -> None:
    """Replace all that stands below the TODO."""
    above, todo, _ = path.read_text(encoding="utf-8").partition(_TODO)
    assert todo
    path.write_text(f"{above.rstrip()}\n\n{lines.rstrip()}\n", encoding="utf-8")


def python_lines(texts: Sequence[str]) -> int:
    """Count the lines that are written."""
    return sum(bool(line.strip()) for text in texts for line in text.splitlines())
