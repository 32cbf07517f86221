"""The page is the host's own, and the host's texts in it are escaped."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import parse_qsl

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.web.pictures import encoded

from wax.config.page import PageSettings
from wax.config.server import ServerSettings
from wax.errors import NotForUsError
from wax.web.branding import BrandedPage

WEB = Path(__file__).parents[2] / "web"
BUILT = (WEB / "index.html").read_text(encoding="utf-8")
ORIGIN = "http://robot.example:8080"


class Read(HTMLParser):
    """A page's head, parsed as a browser does."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.root: dict[str, str | None] = {}
        self.meta: dict[str, str | None] = {}
        self.styles: list[str | None] = []
        self.oembed = ""
        self.title = ""
        self._in_title = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self._in_title = tag == "title"
        found = dict(attrs)
        if tag == "html":
            self.root = found
        if tag == "meta" and (name := found.get("property") or found.get("name")):
            self.meta.setdefault(name, found["content"])
        if tag == "link" and found.get("rel") == "stylesheet":
            self.styles.append(found["href"])
        if tag == "link" and "oembed" in str(found.get("type")):
            self.oembed = str(found["href"])

    def handle_endtag(self, tag: str) -> None:
        self._in_title = False

    def handle_data(self, data: str) -> None:
        self.title += data if self._in_title else ""


def test_without_settings_the_page_is_complete() -> None:
    """Title, description and preview have the page's own words, and nothing more is loaded."""
    page = Read(BrandedPage(PageSettings()).html(BUILT, ORIGIN))
    assert page.title == "WAX"
    assert page.meta["description"] == "Drive a real robot from your browser."
    assert page.meta["og:title"] == "WAX"
    assert page.meta["og:description"] == page.meta["description"]
    assert page.meta["twitter:card"] == "summary"
    assert "og:image" not in page.meta
    assert (page.oembed, page.meta.get("og:video")) == ("", None)
    assert page.root == {"lang": "en", "data-name": "WAX"}
    assert page.styles == []


def test_the_page_is_the_hosts() -> None:
    """Name and sentence are in title, description and preview, and the page knows them at once."""
    settings = PageSettings(name="Rover", sentence="Say hello.", language="de")
    page = Read(BrandedPage(settings, {"voice": ""}).html(BUILT, ORIGIN))
    assert page.title == page.meta["og:title"] == "Rover"
    assert page.meta["description"] == page.meta["og:description"] == "Say hello."
    assert page.root == {
        "lang": "de",
        "data-name": "Rover",
        "data-sentence": "Say hello.",
        "data-language": "de",
        "data-voice": "",
    }


def test_a_page_in_german_is_described_in_german() -> None:
    """Without a sentence of the host's, the page's own is in its language."""
    page = Read(BrandedPage(PageSettings(language="de")).html(BUILT, ORIGIN))
    assert page.meta["description"] == "Steuere einen echten Roboter in deinem Browser."


def test_a_preview_needs_whole_addresses(tmp_path: Path) -> None:
    """It has the host's public address if that is set, otherwise the one requested."""
    file = tmp_path / "robot.png"
    file.write_bytes(encoded("png"))
    settings = PageSettings(picture=str(file))
    for public, base in (("https://robot.example.org", "https://robot.example.org"), ("", ORIGIN)):
        own = BrandedPage(settings, public_url=public)
        assert own.picture is not None
        page = Read(own.html(BUILT, ORIGIN))
        assert page.meta["og:url"] == f"{base}/"
        assert page.meta["og:image"] == f"{base}/preview?{own.picture.digest}"
        assert (page.meta["og:image:width"], page.meta["og:image:height"]) == ("120", "63")
        assert page.meta["twitter:card"] == "summary_large_image"


def test_a_colour_is_a_style_sheet_after_the_pages_own() -> None:
    """It overrides that one, has a new URL when it changes, and has both themes."""
    own = BrandedPage(PageSettings(accent="#7a1fa2"))
    built = BUILT.replace("</head>", '<link rel="stylesheet" href="assets/a.css"></head>')
    assert Read(own.html(built, ORIGIN)).styles == [
        "assets/a.css",
        f"page.css?{own.style_digest}",
    ]
    assert "--accent:#7a1fa2" in own.style
    assert "prefers-color-scheme:dark" in own.style
    assert own.style_digest != BrandedPage(PageSettings(accent="#7a1fa3")).style_digest
    # A rule with another selector than the root's would override it.
    sheets = (WEB / "src/style").glob("*.css")
    text = "".join(sheet.read_text(encoding="utf-8") for sheet in sheets)
    rules = re.findall(r"([^{};\n]+) \{[^{}]*--accent:", text)
    assert {rule.strip() for rule in rules} == {":root"}


def test_the_page_for_frames_knows_that_it_is_one() -> None:
    """It has neither voice nor more cameras, and preloads nothing with the browser's cookies."""
    own = BrandedPage(
        PageSettings(name="Rover"), {"voice": "", "cameras": "2", "player": "browser"}
    )
    frame = Read(text := own.html(BUILT, ORIGIN, is_embed=True))
    told = {"lang": "en", "data-name": "Rover", "data-player": "browser", "data-view": "embed"}
    assert frame.root == told
    assert "preload" in BUILT
    assert "preload" not in text


def test_a_frame_without_an_origin_says_why_and_where_the_page_is() -> None:
    """Such a frame shows only its HTML: a sentence, and an address to copy.

    It has no link, since a browser may show an error in a tab that such a frame opens.
    """
    german = PageSettings(language="de")
    for settings, public in ((PageSettings(), ""), (german, "https://a.example/1")):
        own = BrandedPage(settings, public_url=public)
        end = f" Tab: {public or ORIGIN}/</p>" if settings is german else f" {ORIGIN}/</p>"
        text = own.html(BUILT, ORIGIN, is_embed=True)
        assert end in text
        assert "a" not in Read(text).tags
        assert end not in own.html(BUILT, ORIGIN)


def test_sites_that_may_show_the_page_embed_a_pasted_link(tmp_path: Path) -> None:
    """The head names the oEmbed address, and the answer is a frame of a size that fits."""
    file = tmp_path / "robot.png"
    file.write_bytes(encoded("png"))
    settings = PageSettings(name='A "real" one', picture=str(file), embed_on=["https://a.example"])
    for public, base in (
        ("https://example.org/robots/1", "https://example.org/robots/1"),
        ("", ORIGIN),
    ):
        own = BrandedPage(settings, public_url=public)
        page = Read(own.html(BUILT, ORIGIN))
        assert page.meta["og:video"] == f"{base}/?view=embed"
        path, _, query = page.oembed.partition("?")
        assert path == f"{base}/oembed"
        asked = dict(parse_qsl(query))
        assert asked == {"url": f"{base}/", "format": "json"}
        told = own.oembed(asked, ORIGIN)
        frame = Framed(str(told["html"]))
        assert frame.found["src"] == f"{base}/?view=embed"
        assert frame.found["title"] == told["title"] == settings.name
        assert (frame.found["width"], frame.found["height"]) == ("640", "480")
        assert (told["version"], told["type"]) == ("1.0", "video")
        assert told["thumbnail_url"] == page.meta["og:image"]
    small = own.oembed(asked | {"maxwidth": "100", "maxheight": "9" * 5000}, ORIGIN)
    assert own.oembed(asked | {"maxwidth": "0" * 5000 + "100"}, ORIGIN)["width"] == 100
    assert (small["width"], small["height"]) == (100, 75)
    assert "thumbnail_url" not in small, "it is wider"
    low = own.oembed(asked | {"maxwidth": "many", "maxheight": "60"}, ORIGIN)
    assert (low["width"], low["height"]) == (80, 60)
    assert own.oembed(asked | {"maxheight": "0"}, ORIGIN)["height"] == 1


@pytest.mark.parametrize(("shape", "high"), [((1280, 720), 360), ((480, 640), 853)])
def test_a_frame_has_the_shape_of_the_picture(shape: tuple[int, int], high: int) -> None:
    """The frame of a wide or an upright picture leaves no bars, in the head and in the answer."""
    own = BrandedPage(PageSettings(embed_on=["https://a.example"]), shape=shape)
    assert Read(own.html(BUILT, ORIGIN)).meta["og:video:height"] == str(high)
    told = own.oembed({"url": f"{ORIGIN}/", "maxheight": "72"}, ORIGIN)
    assert (told["width"], told["height"]) == (72 * shape[0] // shape[1], 72)


@pytest.mark.parametrize(
    ("url", "more", "status"),
    [
        (f"{ORIGIN}/?lang=de#host=secret", {}, 200),
        (ORIGIN, {}, 200),
        (f"{ORIGIN}/", {"format": "xml"}, 501),
        (f"{ORIGIN}.evil.example/", {}, 404),
        (f"{ORIGIN}/assets/a.js", {}, 404),
        (f"{ORIGIN}0/", {}, 404),
        ("http://robot.example/", {}, 404),
        ("ftp://robot.example:8080/", {}, 404),
        ("https://museum.example/", {}, 404),
        ("https://", {}, 404),
        ("", {}, 404),
    ],
)
def test_no_other_link_is_embedded(url: str, more: dict[str, str], status: int) -> None:
    """No other format is supported either, and a link's secret is not echoed."""
    own = BrandedPage(PageSettings(embed_on=["https://a.example"]))
    if status == 200:
        assert "secret" not in str(own.oembed({"url": url} | more, ORIGIN))
        return
    with pytest.raises(NotForUsError) as refused:
        own.oembed({"url": url} | more, ORIGIN)
    assert refused.value.status == status


class Framed(HTMLParser):
    """The one element of an answer, parsed as a browser does."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: dict[str, str | None] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert (tag, self.found) == ("iframe", {})
        self.found = dict(attrs)


ANYTHING = st.text(
    st.characters(exclude_categories=["Cc", "Cs"]) | st.sampled_from("<>\"'&\\/g1"),
    min_size=1,
    max_size=40,
)


@given(ANYTHING, ANYTHING)
def test_the_hosts_texts_are_escaped(name: str, sentence: str) -> None:
    """None of them ends an attribute, begins an element or is read as an entity."""
    plain = Read(BrandedPage(PageSettings()).html(BUILT, ORIGIN))
    page = Read(BrandedPage(PageSettings(name=name, sentence=sentence)).html(BUILT, ORIGIN))
    assert page.title == name
    assert page.root["data-name"] == name
    assert page.root["data-sentence"] == sentence
    assert page.meta["description"] == page.meta["og:description"] == sentence
    assert page.tags == plain.tags


@pytest.mark.parametrize(
    "url",
    [
        "https://Müller.EXAMPLE/Robot/",
        "HTTPS://XN--MLLER-KVA.example:443/Robot",
        "http://xn--mller-kva.example/Robot/?utm_source=x",
        "http://müller.example:80/Robot",
        "https://xn--mller-kva.example./Robot",
    ],
)
def test_a_link_is_the_pages_however_it_is_written(url: str) -> None:
    """Scheme, default port, case, and the form of an international name do not matter."""
    server = ServerSettings(public_url="https://müller.example/Robot")
    own = BrandedPage(PageSettings(embed_on=["https://a.example"]), public_url=server.public_url)
    told = own.oembed({"url": url}, ORIGIN)
    assert told["provider_url"] == "https://xn--mller-kva.example/Robot/"
    with pytest.raises(NotForUsError):
        own.oembed({"url": url.replace("Robot", "robot")}, ORIGIN)
