"""Rooms whose peers are fakes."""

from __future__ import annotations

import pytest
from tests.session.rig import Rig, fake_peers


@pytest.fixture(autouse=True)
def _peers(monkeypatch: pytest.MonkeyPatch) -> None:
    fake_peers(monkeypatch)


@pytest.fixture
def rig() -> Rig:
    return Rig(
        {
            "turns": {"turn_s": 5.0},
            "server": {"max_viewers": 2, "public_url": "https://robot.example.org"},
            "sync": {"operator": {"policy": "video-first"}},
        }
    )
