"""A network between two ends on one machine, with the delays, losses and rates of a profile."""

from tests.link.profile import DRIVE, Profile, load

from e2e.link.link import End, Link

__all__ = ["DRIVE", "End", "Link", "Profile", "load"]
