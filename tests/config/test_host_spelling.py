"""Host names and addresses are normalized to what browsers send."""

from __future__ import annotations

import pytest

from wax.config import settings as config
from wax.config.host_spelling import of_host, of_url, spellings


@pytest.mark.parametrize(
    ("written", "sent"),
    [
        ("Robot.Example", "robot.example"),
        ("wax_robot", "wax_robot"),
        ("müller.example", "xn--mller-kva.example"),
        ("MÜLLER.example", "xn--mller-kva.example"),
        ("xn--mller-kva.example", "xn--mller-kva.example"),
        ("straße.example", "xn--strae-oqa.example"),
        ("робот。рф", "xn--90azbfn.xn--p1ai"),
        ("203.0.113.7", "203.0.113.7"),
        ("2001:DB8:0::7", "2001:db8::7"),
        ("", ""),
    ],
)
def test_a_host(written: str, sent: str) -> None:
    """Names become lower-case ASCII, and IP addresses their shortest form."""
    assert of_host(written) == sent


@pytest.mark.parametrize(
    ("written", "sent"),
    [
        ("https://Robot.Example.org", "https://robot.example.org"),
        ("HTTPS://robot.example.org:443/Robot", "https://robot.example.org/Robot"),
        ("http://robot.example.org:443", "http://robot.example.org:443"),
        ("http://müller.example:8080/a?B", "http://xn--mller-kva.example:8080/a?B"),
        ("http://[2001:DB8:0::7]:8080", "http://[2001:db8::7]:8080"),
        ("stun:Müller.example:3478", "stun:xn--mller-kva.example:3478"),
        ("turns:Relay.example?transport=tcp", "turns:relay.example?transport=tcp"),
        ("https://Ada:Pass@Example.org", "https://Ada:Pass@Example.org"),
        ("nonsense", "nonsense"),
        ("", ""),
    ],
)
def test_an_address(written: str, sent: str) -> None:
    """Only a URL's scheme, host and default port change; an invalid URL is left to its key."""
    assert of_url(written) == sent


def test_what_programs_may_send_that_do_not_know_it() -> None:
    """A host has a second spelling in its language's letters, if it can be decoded."""
    assert spellings("xn--mller-kva.example") == {"xn--mller-kva.example", "müller.example"}
    assert spellings("robot.example") == {"robot.example"}
    assert spellings("xn--a.example") == {"xn--a.example"}


@pytest.mark.parametrize(
    ("tree", "key", "kept"),
    [
        ({"server": {"host": "Müller"}}, "server.host", "xn--mller-kva"),
        ({"server": {"names": ["Wax_Robot"]}}, "server.names", ["wax_robot"]),
        (
            {"server": {"public_url": "https://müller.example:443"}},
            "server.public_url",
            "https://xn--mller-kva.example",
        ),
        (
            {"page": {"embed_on": ["https://müller.example"]}},
            "page.embed_on",
            ["https://xn--mller-kva.example"],
        ),
        (
            {"network": {"stun": ["stun:müller.example:1"]}},
            "network.stun",
            ["stun:xn--mller-kva.example:1"],
        ),
        (
            {"mqtt": {"url": "mqtt://müller.example"}},
            "mqtt.url",
            "mqtt://xn--mller-kva.example",
        ),
    ],
)
def test_the_configuration_keeps_it_so(
    tree: dict[str, dict[str, object]], key: str, kept: object
) -> None:
    """Each key that names a host is normalized."""
    table, _, name = key.partition(".")
    assert getattr(getattr(config.parse(tree, "robot.toml"), table), name) == kept
