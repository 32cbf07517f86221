"""How many cases a property is tried with.

A test gives its full number. `make unit` and `make test` try a tenth of it, other cases each time
(in CI the same ones); `make test-all` tries all, by ``pytest --hypothesis-profile=full``.
"""

from __future__ import annotations

from typing import Any, Final

import pytest
from hypothesis import HealthCheck, settings

_FULL: Final = 100
"""Hypothesis's number where a test gives none."""
_LEAST: Final = 10
UNTIMED: Final = (HealthCheck.too_slow,)


def load_profiles() -> None:
    """Load the profile `quick`, and prepare `full`.

    Nothing is timed: a busy machine is no failure. Both build on the profile that Hypothesis has
    loaded by itself: in CI that one draws the same examples each time and stores none.
    """
    for name, most in (("full", _FULL), ("quick", _FULL // 10)):
        settings.register_profile(
            name, deadline=None, max_examples=most, suppress_health_check=UNTIMED
        )
    settings.load_profile("quick")


def share_of(full: int) -> int:
    """Return the loaded profile's share of a number of cases, at least one."""
    return max(1, full * settings().max_examples // _FULL)


def examples(full: int, **more: Any) -> settings:
    """Try a property with the loaded profile's share of `full` examples, at least ten."""
    return settings(max_examples=max(share_of(full), min(full, _LEAST)), **more)


def at_length(*cases: Any) -> list[Any]:
    """Mark these cases of a parametrised test for `make test-all` alone."""
    several = [case if isinstance(case, tuple) else (case,) for case in cases]
    return [pytest.param(*values, marks=pytest.mark.full) for values in several]
