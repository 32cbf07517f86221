"""The page is the host's own, and what they write in it is nothing but text."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
from tests.web.test_preview_picture import encoded

from wax.config.page import PageSettings
from wax.web.branding import BrandedPage

BUILT = (Path(__file__).parents[2] / "web" / "index.html").read_text(encoding="utf-8")
ORIGIN = "http://robot.example:8080"


class Read(HTMLParser):
    """What a browser makes of a page's head."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.root: dict[str, str | None] = {}
        self.meta: dict[str, str | None] = {}
        self.styles: list[str | None] = []
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

    def handle_endtag(self, tag: str) -> None:
        self._in_title = False

    def handle_data(self, data: str) -> None:
        self.title += data if self._in_title else ""


def test_without_settings_the_page_is_complete() -> None:
    """Title, description and preview have words of the page's own, and there is no more to load."""
    page = Read(BrandedPage(PageSettings()).html(BUILT, ORIGIN))
    assert page.title == "WAX"
    assert page.meta["description"] == "Drive a real robot from your browser."
    assert page.meta["og:title"] == "WAX"
    assert page.meta["og:description"] == page.meta["description"]
    assert page.meta["twitter:card"] == "summary"
    assert "og:image" not in page.meta
    assert page.root == {"lang": "en", "data-name": "WAX"}
    assert page.styles == []


def test_the_page_is_the_hosts() -> None:
    """Name and sentence are title, description, preview, and known to the page at once."""
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
    """Where the host says nothing, the page's own sentence is in its language."""
    page = Read(BrandedPage(PageSettings(language="de")).html(BUILT, ORIGIN))
    assert page.meta["description"] == "Steuere einen echten Roboter in deinem Browser."


def test_a_preview_needs_whole_addresses(tmp_path: Path) -> None:
    """The host's public address where it is set, otherwise the one by which somebody came."""
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
    """It outranks that one, is new by name when it changes, and has both themes."""
    own = BrandedPage(PageSettings(accent="#7a1fa2"))
    built = BUILT.replace("</head>", '<link rel="stylesheet" href="assets/a.css"></head>')
    assert Read(own.html(built, ORIGIN)).styles == [
        "assets/a.css",
        f"page.css?{own.style_digest}",
    ]
    assert "--accent:#7a1fa2" in own.style
    assert "prefers-color-scheme:dark" in own.style
    assert own.style_digest != BrandedPage(PageSettings(accent="#7a1fa3")).style_digest


ANYTHING = st.text(
    st.characters(exclude_categories=["Cc", "Cs"]) | st.sampled_from("<>\"'&\\/g1"),
    min_size=1,
    max_size=40,
)


@given(ANYTHING, ANYTHING)
def test_whatever_a_host_writes_is_text(name: str, sentence: str) -> None:
    """No name ends an attribute, begins an element or is read as an entity."""
    plain = Read(BrandedPage(PageSettings()).html(BUILT, ORIGIN))
    page = Read(BrandedPage(PageSettings(name=name, sentence=sentence)).html(BUILT, ORIGIN))
    assert page.title == name
    assert page.root["data-name"] == name
    assert page.root["data-sentence"] == sentence
    assert page.meta["description"] == page.meta["og:description"] == sentence
    assert page.tags == plain.tags
