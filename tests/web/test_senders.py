"""No client can forge its address or the host that it asked for."""

from __future__ import annotations

import pytest
from aiohttp.test_utils import make_mocked_request
from multidict import CIMultiDict
from tests.web.foreign import FOREIGN_ORIGINS

from wax.errors import NotForUsError
from wax.web.senders import Proxies, Seen, is_same_origin


@pytest.mark.parametrize(
    ("trusted", "remote", "forwarded", "expected"),
    [
        ([], "192.0.2.7", None, "192.0.2.7"),
        ([], "127.0.0.1", "198.51.100.1", "127.0.0.1"),
        (["10.0.0.1"], "192.0.2.7", "198.51.100.1", "192.0.2.7"),
        (["127.0.0.1"], "127.0.0.1", "198.51.100.1", "198.51.100.1"),
        (["::1"], "::1", "203.0.113.9, 198.51.100.1", "198.51.100.1"),
        (["127.0.0.1", "10.0.0.0/8"], "127.0.0.1", "203.0.113.9, 10.1.1.1", "203.0.113.9"),
        (["127.0.0.1", "10.0.0.0/8"], "127.0.0.1", "10.2.2.2, 10.1.1.1", "10.2.2.2"),
        (["127.0.0.1"], "127.0.0.1", None, "127.0.0.1"),
        (["127.0.0.1"], "127.0.0.1", "nonsense", "127.0.0.1"),
        (["127.0.0.1"], "127.0.0.1", "198.51.100.1, ", "127.0.0.1"),
        (["127.0.0.1"], "::ffff:127.0.0.1", "198.51.100.1", "198.51.100.1"),
        ([], "2001:db8:1:2:3:4:5:6", None, "2001:db8:1:2::/64"),
        (["127.0.0.1"], "127.0.0.1", "2001:db8:1:2::9", "2001:db8:1:2::/64"),
        ([], "::ffff:192.0.2.7", None, "192.0.2.7"),
        ([], "", None, ""),
    ],
)
def test_only_trusted_proxies_are_believed(
    trusted: list[str], remote: str, forwarded: str | None, expected: str
) -> None:
    """Only the last entry that is no proxy's counts; a proxy that adds none is the sender."""
    headers = {} if forwarded is None else {"X-Forwarded-For": forwarded}
    request = make_mocked_request("POST", "/", headers=headers).clone(remote=remote)
    assert Proxies(trusted).seen(request).sender == expected


@pytest.mark.parametrize("name", ["Forwarded", "X-Forwarded-For", "X-Forwarded-Proto"])
def test_no_client_has_thousands_of_senders_looked_at(name: str) -> None:
    """What they add is refused by its length; the proxy's own is at its end."""
    own = {"Forwarded": "for=198.51.100.1", "X-Forwarded-For": "198.51.100.1"}.get(name, "https")
    said = "," * 1000 + own
    request = make_mocked_request("GET", "/", headers={name: said}).clone(remote="127.0.0.1")
    proxies = Proxies(["127.0.0.1"])
    assert proxies.seen(request).sender == ("127.0.0.1" if own == "https" else "198.51.100.1")
    longer = make_mocked_request("GET", "/", headers={name: "," * 100 + said})
    with pytest.raises(NotForUsError, match="too long"):
        proxies.seen(longer.clone(remote="127.0.0.1"))


@pytest.mark.parametrize(
    ("trusted", "claimed", "expected"),
    [
        (["127.0.0.1"], "https", "https"),
        (["127.0.0.1"], "HTTPS", "https"),
        (["127.0.0.1"], "https,http", "https"),
        (["127.0.0.1"], "http, https", "http"),
        (["127.0.0.1"], "wss", "https"),
        (["127.0.0.1"], "ws", "http"),
        (["127.0.0.1"], "gopher", "http"),
        (["127.0.0.1"], None, "http"),
        ([], "https", "http"),
    ],
)
def test_the_scheme_is_the_connections_own(
    trusted: list[str], claimed: str | None, expected: str
) -> None:
    """Behind trusted proxies it is the one that the first of them saw, WebSocket or HTTP."""
    headers = {} if claimed is None else {"X-Forwarded-Proto": claimed}
    request = make_mocked_request("GET", "/", headers=headers).clone(remote="127.0.0.1")
    assert Proxies(trusted).seen(request).scheme == expected


@pytest.mark.parametrize(
    ("trusted", "headers", "expected"),
    [
        (["127.0.0.1"], {"X-Forwarded-Host": "robot.example"}, ("127.0.0.1", "robot.example")),
        ([], {"X-Forwarded-Host": "robot.example"}, ("127.0.0.1", "inside:8080")),
        (
            ["127.0.0.1"],
            {"Forwarded": 'for="[2001:db8::1]:4711";proto=https;host=robot.example'},
            ("2001:db8::/64", "robot.example"),
        ),
        (
            ["127.0.0.1", "10.0.0.0/8"],
            {"Forwarded": "for=6.6.6.6;host=made.up, for=198.51.100.1;host=a, for=10.0.0.1;host=b"},
            ("198.51.100.1", "a"),
        ),
        (
            ["127.0.0.1", "10.0.0.0/8"],
            {"X-Forwarded-For": "6.6.6.6, 198.51.100.1, 10.0.0.1", "X-Forwarded-Host": "x, a, b"},
            ("198.51.100.1", "a"),
        ),
        (
            ["127.0.0.1"],
            {"X-Forwarded-For": "198.51.100.1:4711", "X-Forwarded-Host": "robot.example"},
            ("198.51.100.1", "robot.example"),
        ),
        (["127.0.0.1"], {"Forwarded": "for=unknown"}, ("127.0.0.1", "inside:8080")),
        (["127.0.0.1"], {"Forwarded": "=;;,"}, ("127.0.0.1", "inside:8080")),
    ],
)
def test_a_proxys_claims_about_its_client(
    trusted: list[str], headers: dict[str, str], expected: tuple[str, str]
) -> None:
    """The outermost trusted proxy's host and sender count, in both families of headers."""
    request = make_mocked_request("GET", "/", headers={"Host": "inside:8080", **headers})
    seen = Proxies(trusted).seen(request.clone(remote="127.0.0.1"))
    assert (seen.sender, seen.host) == expected


@pytest.mark.parametrize(
    "forwarded", ["for=203.0.113.9", "for=127.0.0.1", "for=unknown", "proto=https", "for=10.0.0.1"]
)
def test_two_different_senders_are_refused(forwarded: str) -> None:
    """If the two families of headers name different senders, a client has forged one."""
    headers = {"Host": "inside", "X-Forwarded-For": "198.51.100.1", "Forwarded": forwarded}
    request = make_mocked_request("GET", "/", headers=headers).clone(remote="127.0.0.1")
    with pytest.raises(NotForUsError, match="two different senders") as refused:
        Proxies(["127.0.0.1"]).seen(request)
    assert refused.value.status == 400
    assert Proxies([]).seen(request).sender == "127.0.0.1", "from anybody else both are ignored"


@pytest.mark.parametrize(
    ("x_forwarded_for", "forwarded", "expected"),
    [
        ([], [], "127.0.0.1"),
        (["6.6.6.6, 198.51.100.1"], [], "198.51.100.1"),
        (["6.6.6.6", "198.51.100.1"], [], "198.51.100.1"),
        ([], ['for=6.6.6.6, FOR="[2001:db8::1]:9";proto=https'], "2001:db8::/64"),
        (["nonsense"], ["for=198.51.100.1"], "127.0.0.1"),
    ],
)
def test_the_sender_before_parsing(
    x_forwarded_for: list[str], forwarded: list[str], expected: str
) -> None:
    """A request is charged to the same sender before it is parsed as afterwards."""
    found = Proxies(["127.0.0.1"]).sender("127.0.0.1", x_forwarded_for, forwarded)
    assert found == expected
    assert Proxies([]).sender("192.0.2.7", x_forwarded_for, forwarded) == "192.0.2.7"


@pytest.mark.parametrize(
    ("scheme", "host", "origin"),
    [
        ("http", "robot:80", "http://robot"),
        ("https", "Robot:443", "https://robot"),
        ("http", "robot:443", "http://robot:443"),
        ("https", "robot", "https://robot"),
        ("http", "[::1]:80", "http://[::1]"),
    ],
)
def test_the_origin_of_our_page(scheme: str, host: str, origin: str) -> None:
    """Browsers leave out the scheme's default port, and write names in lower case."""
    assert Seen("", scheme, host).origin == origin


ROBOT = "http://robot:8080"


@pytest.mark.parametrize("origin", FOREIGN_ORIGINS)
def test_other_origins_are_not_our_page(origin: str) -> None:
    """Scheme, host and port must be exactly the same."""
    headers = {"Host": "robot:8080", "Origin": origin}
    assert not is_same_origin(make_mocked_request("POST", "/", headers=headers), ROBOT)


def test_two_origins_are_refused() -> None:
    """Our own origin does not excuse a foreign second one."""
    headers = CIMultiDict(Host="robot:8080")
    headers.extend([("Origin", "http://robot:8080"), ("Origin", "http://evil.example")])
    assert not is_same_origin(make_mocked_request("POST", "/", headers=headers), ROBOT)


@pytest.mark.parametrize("site", ["cross-site", "same-site", "", "Same-Origin", "anything"])
def test_other_sites_by_fetch_metadata(site: str) -> None:
    """Another port of this machine is the same site, but another origin."""
    headers = {"Host": "robot:8080", "Sec-Fetch-Site": site}
    assert not is_same_origin(make_mocked_request("POST", "/", headers=headers), ROBOT)


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Origin": "http://robot:8080"},
        {"Origin": "http://robot:8080", "Sec-Fetch-Site": "same-origin"},
        {"Sec-Fetch-Site": "none"},
    ],
)
def test_our_page_and_programs(headers: dict[str, str]) -> None:
    """Our own page, a typed address, and programs other than browsers are accepted."""
    headers = {"Host": "robot:8080", **headers}
    assert is_same_origin(make_mocked_request("POST", "/", headers=headers), ROBOT)
