"""The operator in a process of its own."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from wax.client.operator import Operator
from wax.client.process import OrderedOperator

if TYPE_CHECKING:
    from pathlib import Path

    import pytest


async def test_a_reconnected_operator_holds_what_it_held(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each part of the motion and the dead-man are as before the reconnection."""

    async def connect(_: Operator) -> None: ...

    monkeypatch.setattr(Operator, "connect", connect)
    ordered = OrderedOperator("http://127.0.0.1:9", "ada", tmp_path / "cookies")
    old = ordered._operator
    old.steer(0.5, -0.25, 0.75)
    ordered.obey("reconnect")
    await asyncio.gather(*ordered._works)
    new = ordered._operator
    assert new is not old
    assert (new.linear, new.angular, new.lateral, new.held) == (0.5, -0.25, 0.75, True)
    await ordered.close()
