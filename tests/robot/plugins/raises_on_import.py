"""A driver that cannot even be imported."""

raise OSError("no bus")
