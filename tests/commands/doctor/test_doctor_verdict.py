"""How a check is run: no failure ends the others."""

from __future__ import annotations

import threading

import pytest

from wax.commands.doctor.verdict import Check, Verdict, examine, ok
from wax.errors import StateError


def _fail(error: Exception) -> Verdict:
    raise error


@pytest.mark.parametrize(
    ("error", "says"), [(OSError("no bus"), "no bus"), (KeyError(), "KeyError")]
)
def test_a_check_that_raises_is_bad(error: Exception, says: str) -> None:
    """An exception becomes a bad verdict in words."""
    verdict = examine(Check("camera", lambda: _fail(error)))
    assert (verdict.level, says in verdict.sentence) == ("bad", True)


def test_a_sentence_of_ours_stays_one() -> None:
    """An error with a sentence of ours keeps it, without advice to report a bug."""
    verdict = examine(Check("disk", lambda: _fail(StateError("no home; set state_dir"))))
    assert (verdict.level, verdict.sentence) == ("bad", "no home; set state_dir")
    assert "Report" not in verdict.advice


def test_a_check_that_hangs_is_bad() -> None:
    """A check that exceeds its limit is bad."""
    released = threading.Event()

    def hang() -> Verdict:
        released.wait()
        return ok("too late")

    verdict = examine(Check("camera", hang, limit_s=0.05))
    released.set()
    assert (verdict.level, "0.05 s" in verdict.sentence) == ("bad", True)


def test_a_check_that_is_well_is_believed() -> None:
    """A verdict is returned unchanged."""
    assert examine(Check("clock", lambda: ok("fine"))) == ok("fine")
