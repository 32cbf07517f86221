"""`wax tape export --lerobot`: checks what was asked, and that its library is installed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from wax.dataset.piece_writer import Options
    from wax.tape.selection import Selection

_MOST_FPS: Final = 240


def export_lerobot(
    selection: Selection, folder: Path, options: Options, *, tell: Callable[[str], None]
) -> str:
    """Export a dataset, and return what to print; raises `ConfigError` or `StateError`."""
    fps, drop_under_s = options.fps, options.drop_under_s
    if fps is not None and not 1 <= fps <= _MOST_FPS:
        raise ConfigError(f"--fps: got {fps}; allowed is 1 to {_MOST_FPS}")
    if not drop_under_s >= 0:
        raise ConfigError(f"--drop-under: got {drop_under_s}; allowed is 0 and more")
    try:
        from wax.dataset.export import export  # noqa: PLC0415  # it needs pyarrow
    except ModuleNotFoundError as error:
        raise ConfigError(
            f"--lerobot needs {error.name}, which is not installed:"
            ' pip install "wax-teleop[dataset]"'
        ) from error
    return export(selection, folder, options, tell=tell)
