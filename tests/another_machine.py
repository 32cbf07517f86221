"""A pytest plugin that simulates another machine: another time, and folders in another order."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

_LATER_S = 1_000_003.0
_list, _scan, _time = os.listdir, os.scandir, vars(time)["time"]


class _Scanned:
    """The result of `os.scandir`, backwards: an iterator that is also a context manager."""

    def __init__(self, *where: Any) -> None:
        with _scan(*where) as found:
            self._found = reversed(list(found))

    def __iter__(self) -> Iterator[Any]:
        return self._found

    def __next__(self) -> Any:
        return next(self._found)

    def __enter__(self) -> _Scanned:
        return self

    def __exit__(self, *_: object) -> None: ...

    def close(self) -> None: ...


vars(os).update(scandir=_Scanned, listdir=lambda *where: _list(*where)[::-1])
vars(time).update(time=lambda: _time() + _LATER_S)
