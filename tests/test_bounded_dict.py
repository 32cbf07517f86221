"""The dictionary that strangers fill: it keeps what was set last."""

from __future__ import annotations

from wax.bounded_dict import BoundedDict


def test_the_key_that_was_set_longest_ago_goes() -> None:
    """To set a key again makes it the newest."""
    kept = BoundedDict[str, int](3)
    for number, key in enumerate("abcad"):
        kept[key] = number
    assert list(kept.items()) == [("c", 2), ("a", 3), ("d", 4)]
