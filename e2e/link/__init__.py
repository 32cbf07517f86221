"""A network between two ends on one machine, with the delays, losses and rates of a profile."""

from tests.link.errors import LinkError, ProfileError
from tests.link.profile import DRIVE, Profile, load, names

from e2e.link.link import End, Link

__all__ = [
    "DRIVE",
    "End",
    "Link",
    "LinkError",
    "Profile",
    "ProfileError",
    "load",
    "names",
]
