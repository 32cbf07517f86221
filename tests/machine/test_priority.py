"""The priority of a process: raised with its session, which Linux weighs first."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from wax.machine import priority


@pytest.fixture
def refusals(monkeypatch: pytest.MonkeyPatch) -> list[type[OSError]]:
    """Refuse the writes to come by these errors, each of which is taken off as it is raised."""
    left: list[type[OSError]] = []

    def write(*_: object, **_how: object) -> None:
        if left:
            raise left.pop(0)

    monkeypatch.setattr(os, "setpriority", lambda *_: None)
    monkeypatch.setattr(os, "getsid", lambda _: os.getpid())
    monkeypatch.setattr(Path, "write_text", write)
    monkeypatch.setattr(priority, "_PAUSE_S", 0.0)
    return left


def test_it_is_asked_again_where_others_have_just_asked(refusals: list[type[OSError]]) -> None:
    refusals += [BlockingIOError, BlockingIOError]
    priority.raise_priority()
    assert refusals == []


def test_a_refusal_is_final(refusals: list[type[OSError]]) -> None:
    refusals += [PermissionError, BlockingIOError]
    priority.raise_priority()
    assert refusals == [BlockingIOError]


def test_a_session_of_somebody_else_stays(
    refusals: list[type[OSError]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "getsid", lambda _: 1)
    refusals += [BlockingIOError]
    priority.raise_priority()
    assert refusals == [BlockingIOError]
