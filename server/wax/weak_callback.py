"""Callbacks that do not keep their object alive.

Reference cycles are freed only by the garbage collector, whose full run blocks the event loop and
is therefore rare (`wax.machine.memory`).
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, ParamSpec

if TYPE_CHECKING:
    from collections.abc import Callable

_P = ParamSpec("_P")


def weak_callback(method: Callable[_P, None]) -> Callable[_P, None]:
    """Return a callback that calls this bound method, and does nothing once its object is gone."""
    found = weakref.WeakMethod(method)

    def call(*args: _P.args, **kwargs: _P.kwargs) -> None:
        alive = found()
        if alive is not None:
            alive(*args, **kwargs)

    return call
