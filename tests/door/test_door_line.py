"""The line that a door prints for a robot."""

from __future__ import annotations

import hashlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.door.door_lines import SEED, door_line
from tests.examples import examples

from wax.door import line
from wax.errors import ConfigError

WHOLE = door_line()


def test_a_line_says_all_that_a_robot_must_know() -> None:
    """A line is parsed even if an e-mail has wrapped it."""
    found = line.read(f" {WHOLE[:60]}\r\n  {WHOLE[60:]}\n")
    assert (found.host, found.port) == ("robot.example.org", 20001)
    assert found.host_key.startswith("ssh-ed25519 AAAAC3NzaC1lZDI1NTE5AAAAI")
    assert found.seed == SEED
    assert found.relay_secret == 8 * "c0ffee42"
    assert "c0ffee42" not in repr(found)


@given(st.data())
@examples(300)
def test_no_line_with_one_wrong_sign_is_taken(data: st.DataObject) -> None:
    """A line cut, mistyped or doubled anywhere is refused, and not quoted: it is a secret."""
    at = data.draw(st.integers(0, len(WHOLE) - 1))
    sign = data.draw(st.sampled_from(["", "x", "0", ":", "é", WHOLE[at] * 2]))
    wrong = WHOLE[:at] + sign + WHOLE[at + 1 :]
    if wrong == WHOLE:
        return
    with pytest.raises(ConfigError) as refused:
        line.read(wrong)
    assert str(refused.value).count("\n") == 0
    assert WHOLE[60:90] not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no line of a door"),
        ("ssh-ed25519 AAAA", "no line of a door"),
        (WHOLE[:-40], "cut or mistyped"),
        (WHOLE.replace("wax-door-1", "wax-door-2"), "another version"),
        (door_line(port="0"), "not understood"),
        (door_line(port="70000"), "not understood"),
        (door_line(name="robot_1;rm"), "not understood"),
        (f"wax-door-1::{hashlib.sha256(b'wax-door-1:').hexdigest()[:8]}", "not understood"),
    ],
)
def test_a_wrong_line_has_its_sentence(text: str, why: str) -> None:
    """The sentence says what is wrong with the line."""
    with pytest.raises(ConfigError, match=why):
        line.read(text)
