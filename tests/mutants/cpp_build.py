"""The firmware's core as a shared library, unchanged or with a fault in one of its files."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Final

from tests.mutants.fork_server import NothingToTestError
from tests.mutants.plan import CORE

_AS_SHIPPED: Final = ("-O2",)
# C++'s undefined behaviour ends the program instead of succeeding by chance.
_WATCHED: Final = ("-O1", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error")
_FLAGS: Final = ("-std=c++11", "-fPIC", "-w")


def build_whole(tree: Path, out: Path) -> Path:
    """Compile the core unchanged, for comparison; raises `CalledProcessError`."""
    out.mkdir()
    for source in _sources(tree / CORE):
        _compile(source, out, _AS_SHIPPED)
    return out


def build(tree: Path, file: str, source: str, out: Path, whole: Path | None) -> Path:
    """Build the library with another source for one file; return its path.

    `whole` is the result of `build_whole`, to compare with. Raises `NothingToTestError` if the
    compiler says that the source is no program, or the same one.
    """
    firmware = tree / "server/firmware"
    shutil.copytree(firmware / "wax/src", out / "wax/src")
    shutil.copytree(firmware / "host", out / "host")
    changed = out / "wax/src/core" / Path(file).name
    changed.write_text(source)
    sources = _sources(changed.parent)
    touched = [changed] if changed in sources else sources
    try:
        shipped = [_compile(one, out, _AS_SHIPPED) for one in touched]
        if whole and all(one.read_bytes() == (whole / one.name).read_bytes() for one in shipped):
            raise NothingToTestError
        library = out / "libwax.so"
        _cc(["-shared", *_WATCHED, *map(str, sources), str(out / "host/capi.cpp")], library)
    except subprocess.CalledProcessError as error:
        raise NothingToTestError from error
    return library


def _sources(core: Path) -> list[Path]:
    return sorted(core.glob("*.cpp"))


def _compile(source: Path, out: Path, flags: tuple[str, ...]) -> Path:
    made = out / f"{source.stem}.o"
    _cc(["-c", *flags, str(source)], made)
    return made


def _cc(arguments: list[str], made: Path) -> None:
    subprocess.run(
        ["c++", *_FLAGS, *arguments, "-o", str(made)],
        check=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
