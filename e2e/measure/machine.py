"""The machine, commit and versions of measured figures."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import subprocess
from pathlib import Path
from typing import Final

import psutil
from pydantic import BaseModel, ConfigDict

from e2e.measure.suite import ROOT

_PACKAGES: Final = ("wax-teleop", "aiortc", "aioice", "aiohttp", "av", "numpy", "playwright")


class Machine(BaseModel):
    """The machine; ratios carry over to another one, absolute times do not."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    cpu: str
    cores: int
    memory_mib: int
    system: str
    python: str
    versions: dict[str, str]
    chromium: str | None

    def __str__(self) -> str:
        return f"{self.cpu}, {self.cores} cores, {self.memory_mib // 1024} GiB, {self.system}"


def describe() -> Machine:
    return Machine(
        cpu=_cpu(),
        cores=os.cpu_count() or 0,
        memory_mib=int(psutil.virtual_memory().total // 2**20),
        system=f"{platform.system()} {platform.release()} {platform.machine()}",
        python=platform.python_version(),
        versions={name: importlib.metadata.version(name) for name in _PACKAGES},
        chromium=_first_line(os.environ.get("WAX_CHROMIUM", "chromium"), "--version"),
    )


def commit() -> str:
    """Return the commit; it ends with ``-dirty`` if tracked files differ from it.

    Figures and tables, which a measurement writes itself, do not count.
    """
    git = ("git", "-C", str(ROOT))
    name = _first_line(*git, "rev-parse", "--short", "HEAD") or "unknown"
    ours = (":!README.md", ":!e2e/published")
    changed = _first_line(*git, "status", "--porcelain", "--untracked-files=no", "--", ".", *ours)
    return f"{name}-dirty" if changed else name


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


def _first_line(*command: str) -> str | None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return next(iter(done.stdout.splitlines()), None)
