"""What a rover's parameters promise."""

from __future__ import annotations

import pytest

from wax.robot.mavlink.failsafe import Promise, broken, obeys_another, promise, told_s, warnings

GOOD = {"FS_GCS_ENABLE": 1.0, "FS_GCS_TIMEOUT": 5.0, "FS_TIMEOUT": 1.5, "FS_ACTION": 2.0}


@pytest.mark.parametrize(
    ("known", "is_guided", "expected"),
    [
        (GOOD, False, Promise(6.5, goes_home=False)),
        (GOOD, True, Promise(3.0, goes_home=False)),
        (GOOD | {"GUID_TIMEOUT": 0.5}, True, Promise(0.5, goes_home=False)),
        (GOOD | {"GUID_TIMEOUT": 0.0}, True, Promise(0.1, goes_home=False)),
        (GOOD | {"GUID_TIMEOUT": 30.0}, True, Promise(6.5, goes_home=False)),
        (GOOD | {"GUID_TIMEOUT": 0.5}, False, Promise(6.5, goes_home=False)),
        (GOOD | {"FS_GCS_ENABLE": 0.0}, False, Promise(None, goes_home=False)),
        (GOOD | {"FS_GCS_ENABLE": 0.0, "FS_ACTION": 1.0}, False, Promise(None, goes_home=False)),
        (GOOD | {"FS_ACTION": 0.0}, False, Promise(None, goes_home=False)),
        (GOOD | {"FS_ACTION": 1.0}, False, Promise(None, goes_home=True)),
        (GOOD | {"FS_ACTION": 4.0}, True, Promise(3.0, goes_home=True)),
        (GOOD | {"FS_ACTION": 5.0}, False, Promise(None, goes_home=False)),
        ({"FS_GCS_ENABLE": 1.0, "FS_ACTION": 2.0}, False, Promise(None, goes_home=False)),
        ({}, True, Promise(None, goes_home=False)),
        ({}, False, Promise(None, goes_home=False)),
    ],
)
def test_only_what_is_known_to_stop_it_counts(
    known: dict[str, float], is_guided: bool, expected: Promise
) -> None:
    """A failsafe that is off, drives home or is partly unknown promises no stop."""
    assert promise(known, is_guided=is_guided) == expected


@pytest.mark.parametrize(
    ("known", "is_guided", "expected"),
    [
        (GOOD, False, 6.5),
        (GOOD | {"GUID_TIMEOUT": 0.5, "FS_GCS_ENABLE": 0.0}, True, 0.5),
        (GOOD | {"FS_GCS_ENABLE": 0.0}, False, 0.0),
        ({"FS_GCS_ENABLE": 0.0}, False, 0.0),
        (GOOD | {"FS_ACTION": 1.0}, False, 0.0),
        (GOOD | {"FS_ACTION": 1.0}, True, 0.0),
        ({"FS_GCS_ENABLE": 1.0}, False, None),
        ({"FS_GCS_ENABLE": 1.0, "FS_ACTION": 2.0}, False, None),
        ({}, True, None),
    ],
)
def test_no_failsafe_differs_from_an_unknown_one(
    known: dict[str, float], is_guided: bool, expected: float | None
) -> None:
    """0 means that it never stops by itself, None that it is unknown."""
    assert told_s(known, promise(known, is_guided=is_guided)) == expected


def test_a_requirement_is_met_or_a_problem() -> None:
    """0 requires none; otherwise a missing or slow failsafe is a problem."""
    kept = Promise(2.0, goes_home=False)
    assert broken(Promise(None, goes_home=False), 0.0) is None
    assert broken(kept, 2.0) is None
    assert "does not promise to stop 2 s" in str(broken(Promise(None, goes_home=False), 2.0))
    assert "only 2 s" in str(broken(kept, 1.5))


def test_warnings_name_the_parameters() -> None:
    """Each dangerous setting gets a warning, a rover that stops gets none."""
    assert warnings(Promise(2.0, goes_home=False)) == []
    one, two = warnings(Promise(None, goes_home=True))
    assert "FS_GCS_ENABLE" in one
    assert "drives home" in two


@pytest.mark.parametrize("name", ["MAV_GCS_SYSID", "SYSID_MYGCS"])
def test_whom_it_obeys(name: str) -> None:
    """The problem uses the firmware's parameter name; unknown is no problem."""
    assert obeys_another({name: 255.0}, 255) is None
    assert obeys_another({}, 255) is None
    sentence = str(obeys_another({name: 250.0}, 255))
    assert name in sentence
    assert "250" in sentence
