"""What the gallery itself promises."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import pytest
import pytest_asyncio

from e2e.gallery import axe, layout

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser, Page

pytestmark = pytest.mark.full


@pytest_asyncio.fixture(loop_scope="session")
async def blank(chromium: Browser) -> AsyncIterator[Page]:
    async with await chromium.new_page(viewport={"width": 400, "height": 300}) as page:
        yield page


_STOP: Final = (
    '<button style="position: fixed; left: 100px; top: 100px; width: 90px; height: 50px">'
)


_FINDINGS: Final[dict[str, tuple[str, str | None]]] = {
    "nothing": (f"{_STOP}Stop</button>", None),
    "no Stop": ("<p>nothing</p>", "there are 0 Stop buttons"),
    "too wide": (f"{_STOP}Stop</button><div style='width: 900px; height: 9px'></div>", "sideways"),
    "Stop outside": (f"{_STOP.replace('top: 100px', 'top: 290px')}Stop</button>", "not in the"),
    "Stop covered": (
        f"{_STOP}Stop</button><div style='position: fixed; inset: 120px 0 0 0'></div>",
        "covered by",
    ),
    "small": (
        f"{_STOP}Stop</button><button style='width: 43px; height: 44px'>x</button>",
        "43 × 44",
    ),
    "larger than it looks": (
        "<style>#x { margin: 60px; position: relative; width: 20px; height: 20px }"
        " #x::after { content: ''; position: absolute; inset: -14px }</style>"
        f"{_STOP}Stop</button><button id=x>x</button>",
        None,
    ),
    "a link in a sentence": (f"{_STOP}Stop</button><p>Read <a href='/x'>this</a> first.</p>", None),
    "disabled": (f"{_STOP}Stop</button><button disabled style='width: 9px'>x</button>", None),
}


async def test_the_layouts_check_finds(blank: Page) -> None:
    """Each fault is found where it is, and none elsewhere."""
    for name, (html, finding) in _FINDINGS.items():
        await blank.set_content(html)
        found = await layout.faults(blank, has_stop=True)
        assert len(found) == (finding is not None), name
        assert all(finding is not None and finding in one for one in found), name


async def test_axe_waits_for_colours_that_change(blank: Page) -> None:
    """A finding that exists only while the theme changes does not count."""
    await blank.set_content(
        "<!doctype html><html lang=en><title>x</title><main><h1>x</h1>"
        "<p style='color: #ddd; background: #fff; transition: background 500ms'>words</p></main>"
    )
    assert any("axe color-contrast: " in one for one in await axe.findings(blank))
    await blank.evaluate("document.querySelector('p').style.background = '#000'")
    assert await axe.findings(blank) == []


async def test_the_readers_wishes_are_checked(blank: Page) -> None:
    """A button without an edge in forced colours is found, and so is motion despite the request."""
    await blank.set_content(
        "<style>@keyframes turn { to { rotate: 1turn } }"
        " i { display: block; animation: turn 1s infinite }"
        " @media (prefers-reduced-motion: reduce) { .calm { animation: none } }</style>"
        "<button>ok</button><button style='border: none'>gone</button><i>x</i><i class=calm>x</i>"
    )
    assert await layout.vanished(blank) == ["“gone” has no edge in forced colours"]
    assert await layout.moving(blank) == ["<i.> moves on"]
