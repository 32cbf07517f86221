"""The detection of this machine's devices."""

from __future__ import annotations

from wax.commands.init.found import detect


def test_it_looks_at_this_machine() -> None:
    """Detection never raises, and does not list our own drivers as plug-ins."""
    found = detect()
    assert found.plugged <= len(found.ports)
    assert not {"serial", "simulated"} & set(found.drivers)
