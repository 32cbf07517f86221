"""A fork server: runs tests in processes that have already loaded what all tests need.

So a mutant costs the time of its tests and little more. The tests see a copy of the tree, and the
mutated module replaces the real one when it is imported: no file changes, and the tree may be
edited meanwhile. Hypothesis draws the same examples for all and shrinks no failure.
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.util
import math
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, NoReturn

import hypothesis
import pytest
from tests.mutants.plan import ROOT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from importlib.machinery import ModuleSpec
    from types import ModuleType

_COPIED: Final = ("server", "tests", ".make", "config", "pyproject.toml")
_NOT_COPIED: Final = shutil.ignore_patterns("__pycache__", "web", "node_modules")
_LOADED: Final = (
    "aiohttp",
    "hypothesis.stateful",
    "hypothesis.strategies",
    "numpy",
    "pydantic",
    "pytest_asyncio",
    "serial",
    "structlog",
)
_LOADED_ALREADY: Final = "-Wignore::pytest.PytestAssertRewriteWarning"
_OPTIONS: Final = (
    "-x",
    "-q",
    "--no-header",
    "-p",
    "no:cacheprovider",
    "--timeout=0",
    "--hypothesis-profile=mutants",
    _LOADED_ALREADY,
)
_MEMORY_BYTES: Final = 4 << 30
PASSED, FAILED, BROKEN, NOTHING_TO_TEST, TIMED_OUT = 0, 1, 70, 71, -1000
"""How a run ends: as pytest says, except for the last three."""


class NothingToTestError(Exception):
    """The prepared source is no different program."""


class ForkServer:
    """Forks runs of tests on the copy of the tree in `tree`."""

    def __init__(self, tree: Path) -> None:
        self.tree = tree
        self._ends_s: dict[int, float] = {}

    def start(
        self,
        tests: Sequence[str],
        prepare: Callable[[], None],
        *,
        cpu_s: float,
        wall_s: float,
        log: Path,
    ) -> int:
        """Start running tests after `prepare`, both in a process of their own; return its id.

        `cpu_s` is the most processor time that it may use, `wall_s` the longest that it may take.
        """
        run = os.fork()
        if run == 0:
            _run(self.tree, tests, prepare, cpu_s, log)
        self._ends_s[run] = time.monotonic() + wall_s
        return run

    def wait(self) -> tuple[int, int, float]:
        """Wait until a run ends; return its id, how it ended, and its processor time in s."""
        while True:
            run, status, used = os.wait4(-1, os.WNOHANG)
            if run:
                break
            for late in [run for run, end_s in self._ends_s.items() if end_s < time.monotonic()]:
                _kill(late)
            time.sleep(0.01)
        _kill(run)  # the processes that it may have started
        del self._ends_s[run]
        code = os.waitstatus_to_exitcode(status)
        timed_out = code in {-signal.SIGKILL, -signal.SIGXCPU}
        return run, TIMED_OUT if timed_out else code, used.ru_utime + used.ru_stime

    def end(self) -> None:
        for run in self._ends_s:
            _kill(run)


def _kill(run: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(run, signal.SIGKILL)


@contextmanager
def open_fork_server() -> Iterator[ForkServer]:
    """Copy the tree, load what is needed, and leave nothing behind."""
    hypothesis.settings.register_profile(
        "mutants",
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=[hypothesis.HealthCheck.too_slow],
        phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate],
    )
    for name in _LOADED:
        importlib.import_module(name)
    with tempfile.TemporaryDirectory(prefix="wax-mutants-") as folder:
        for name in _COPIED:
            here, there = ROOT / name, Path(folder) / name
            if here.is_dir():
                shutil.copytree(here, there, ignore=_NOT_COPIED)
            else:
                shutil.copy(here, there)
        server = ForkServer(Path(folder))
        try:
            yield server
        finally:
            server.end()


def use_source(module: str, source: str, tree: Path) -> None:
    """Make this process import a module from this source."""
    sys.meta_path.insert(0, _MutatedModule(module, source, tree))


def _run(
    tree: Path, tests: Sequence[str], prepare: Callable[[], None], cpu_s: float, log: Path
) -> NoReturn:
    code = BROKEN
    try:
        os.setsid()
        out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        for stream in (1, 2):
            os.dup2(out, stream)
        limit_s = math.ceil(cpu_s)
        resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s + 1))
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.chdir(tree)
        # Files that the tests leave behind, killed or not, disappear with the tree.
        tempfile.tempdir = os.environ["TMPDIR"] = str(tree)
        sys.path[:0] = [str(tree), str(tree / "server")]
        prepare()
        # A folder of its own: pytest's search fails if other runs' folders disappear meanwhile.
        own = f"--basetemp={tree / f'tmp-{os.getpid()}'}"
        code = int(pytest.main([*_OPTIONS, own, *tests]))
    except NothingToTestError:
        code = NOTHING_TO_TEST
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(code)


class _MutatedModule(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Gives one module another source; everything else about it is unchanged."""

    def __init__(self, module: str, source: str, tree: Path) -> None:
        self._module = module
        self._source = source
        self._path = tree / "server" / (module.replace(".", "/") + ".py")

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self._module:
            return None
        return importlib.util.spec_from_file_location(fullname, self._path, loader=self)

    def exec_module(self, module: ModuleType) -> None:
        exec(compile(self._source, str(self._path), "exec"), module.__dict__)
