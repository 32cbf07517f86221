"""The host's links and cookies."""

from __future__ import annotations

from wax.access.host_secrets import COOKIE_S, LINK_S, OVERLAP_S, HostSecrets


class Kept(dict[str, float]):
    """A fake of the records' `keep`."""

    def __call__(self, name: str, ends_s: float) -> None:
        self[name] = ends_s


def test_a_link_works_once() -> None:
    """The first to open a link gets a cookie, the second none."""
    hosts = HostSecrets((), Kept())
    secret = hosts.new_link(0.0)
    cookie = hosts.exchange(secret, 1.0)
    assert hosts.sign_in(cookie, 2.0)
    assert hosts.exchange(secret, 2.0) is None


def test_a_link_ends() -> None:
    """A link expires after a day, and an invented secret gives no cookie."""
    hosts = HostSecrets((), Kept())
    assert hosts.exchange(hosts.new_link(0.0), LINK_S) is None
    assert hosts.exchange("guess", 0.0) is None
    assert not hosts.sign_in("guess", 0.0)
    assert not hosts.sign_in(None, 0.0)


def test_only_the_newest_links_work() -> None:
    """Only the newest eight links are valid."""
    hosts = HostSecrets((), Kept())
    links = [hosts.new_link(0.0) for _ in range(9)]
    assert hosts.exchange(links[0], 1.0) is None
    assert hosts.exchange(links[1], 1.0) is not None


def test_a_cookie_changes_with_each_use() -> None:
    """A rotated cookie stays valid for a minute, and cannot be rotated again."""
    hosts = HostSecrets((), Kept())
    first = hosts.exchange(hosts.new_link(0.0), 0.0)
    assert first is not None
    second = hosts.rotate(first, 100.0)
    assert second is not None
    assert hosts.rotate(first, 100.0) is None
    assert hosts.sign_in(first, 100.0 + OVERLAP_S - 1)
    assert not hosts.sign_in(first, 100.0 + OVERLAP_S)
    assert hosts.sign_in(second, COOKIE_S)
    assert not hosts.sign_in(second, COOKIE_S + 100.0)


def test_cookies_survive_a_restart() -> None:
    """Cookies survive a restart as hashes, which let nobody in."""
    kept = Kept()
    hosts = HostSecrets((), kept)
    cookie = hosts.exchange(hosts.new_link(0.0), 0.0)
    assert cookie is not None
    assert cookie not in kept
    assert HostSecrets(kept.items(), kept).sign_in(cookie, 1.0)
    assert not any(HostSecrets(kept.items(), kept).sign_in(name, 1.0) for name in kept)


def test_what_is_over_is_forgotten() -> None:
    """Expired cookies are deleted."""
    hosts = HostSecrets((), Kept())
    for turn in range(100):
        hosts.exchange(hosts.new_link(turn * COOKIE_S), turn * COOKIE_S)
    assert len(hosts._cookies) == 1


def test_a_sign_in_is_all_cookies_that_replace_each_other() -> None:
    """Signing out the others ends their cookies and all unused links, but not one's own cookies."""
    kept = Kept()
    hosts = HostSecrets((), kept)
    mine, theirs = (hosts.exchange(hosts.new_link(0.0), 0.0) for _ in range(2))
    assert mine
    assert theirs
    waiting = hosts.new_link(0.0)
    newest, stolen = hosts.rotate(mine, 1.0), hosts.rotate(theirs, 1.0)
    sign_in = hosts.sign_in(newest, 2.0)
    assert sign_in == hosts.sign_in(mine, 2.0) != hosts.sign_in(stolen, 2.0)
    assert hosts.sign_out_others(sign_in) == 1
    for cookie in (theirs, stolen):
        assert not hosts.sign_in(cookie, 2.0)
    assert hosts.exchange(waiting, 2.0) is None
    after = HostSecrets(kept.items(), kept)
    assert [bool(after.sign_in(one, 2.0)) for one in (newest, stolen)] == [True, False]


def test_a_replaced_cookie_that_comes_again_is_noticed() -> None:
    """A replaced cookie is recognized after its minute, while its successor is valid."""
    hosts = HostSecrets((), Kept())
    first = hosts.exchange(hosts.new_link(0.0), 0.0)
    assert first
    second = hosts.rotate(first, 0.0)
    assert second
    assert not hosts.was_replaced(second, OVERLAP_S)
    assert not hosts.was_replaced("guess", OVERLAP_S)
    assert hosts.was_replaced(first, OVERLAP_S)
    hosts.sign_out_others("another")
    assert not hosts.was_replaced(first, OVERLAP_S)
