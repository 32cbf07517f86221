"""`wax doctor` on who may say who somebody is."""

from __future__ import annotations

import pytest

from wax.commands.doctor import sign_in
from wax.commands.doctor.verdict import examine
from wax.config import settings as config


@pytest.mark.parametrize(
    ("trusted", "level", "names"),
    [(["127.0.0.1"], "ok", "Only 127.0.0.1"), (["10.0.0.0/8"], "warning", "10.0.0.0/8")],
)
def test_it_says_who_is_believed(trusted: list[str], level: str, names: str) -> None:
    """Where a proxy says who people are, its address is named, and a wide network is a warning."""
    tree = {"access": {"proxy": {"person": "Remote-User"}}, "server": {"trusted_proxies": trusted}}
    [check] = sign_in.checks(config.parse(tree, "here"))
    verdict = examine(check)
    assert verdict.level == level
    assert names in verdict.sentence
    assert sign_in.checks(config.load(None)) == []
