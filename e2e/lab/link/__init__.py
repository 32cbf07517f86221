"""A network between two ends on one machine, with the delays, losses and rates of a profile."""

from e2e.lab.link.errors import LinkError, ProfileError, UnavailableError
from e2e.lab.link.link import End, Link
from e2e.lab.link.profile import Profile, load, names

__all__ = [
    "End",
    "Link",
    "LinkError",
    "Profile",
    "ProfileError",
    "UnavailableError",
    "load",
    "names",
]
