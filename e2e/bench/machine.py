"""Which machine and which versions the numbers belong to."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path

from e2e.bench.process import machine_memory_mib
from e2e.bench.servers import ROOT

PACKAGES = ("wax-teleop", "aiortc", "aioice", "aiohttp", "av", "numpy", "playwright")


@dataclass(frozen=True, slots=True)
class Machine:
    """Ratios carry over to another machine, absolute times do not."""

    cpu: str
    cores: int
    memory_mib: int
    system: str
    python: str
    versions: dict[str, str]
    chromium: str | None
    commit: str | None
    load_1min_before: float


def describe() -> Machine:
    return Machine(
        cpu=_cpu(),
        cores=os.cpu_count() or 0,
        memory_mib=machine_memory_mib(),
        system=f"{platform.system()} {platform.release()} {platform.machine()}",
        python=platform.python_version(),
        versions={name: importlib.metadata.version(name) for name in PACKAGES},
        chromium=_first_line("chromium", "--version"),
        commit=_first_line("git", "-C", str(ROOT), "describe", "--always", "--dirty"),
        load_1min_before=os.getloadavg()[0],
    )


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
    lines = done.stdout.splitlines()
    return lines[0].strip() if lines else None
