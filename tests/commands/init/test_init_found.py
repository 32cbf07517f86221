"""What is plugged in here."""

from __future__ import annotations

from wax.commands.init.found import detect


def test_it_looks_at_this_machine() -> None:
    """Whatever is here, it is found without an exception, and our own drivers are no plug-ins."""
    found = detect()
    assert found.plugged <= len(found.ports)
    assert not {"serial", "simulated"} & set(found.drivers)
