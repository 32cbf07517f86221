"""The windows and colours in which each state is photographed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

if TYPE_CHECKING:
    from playwright.async_api import Page

Theme = Literal["light", "dark"]
THEMES: Final[tuple[Theme, ...]] = ("light", "dark")
_SETTLED: Final = """() => new Promise((settled) => {
    requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(settled, 250)));
})"""
"""The page has drawn the new size and colours, and every animation caused by them has ended."""


@dataclass(frozen=True, slots=True)
class Size:
    """A window; in CSS pixels."""

    key: str
    title: str
    width: int
    height: int


UPRIGHT: Final = Size("upright", "phone, upright", 390, 844)
ACROSS: Final = Size("across", "phone, across", 844, 390)
DESKTOP: Final = Size("desktop", "desktop", 1280, 800)


@dataclass(frozen=True, slots=True)
class Device:
    """What a person holds; a phone can be turned, so that it has two sizes, and is touched."""

    key: str
    sizes: tuple[Size, ...]
    options: dict[str, Any]
    """Further options of Playwright's context."""

    @property
    def views(self) -> tuple[View, ...]:
        return tuple(View(size, theme) for size in self.sizes for theme in THEMES)

    @property
    def context(self) -> dict[str, Any]:
        """Playwright's options for a new browser on this device."""
        first = self.sizes[0]
        viewport = {"width": first.width, "height": first.height}
        return {"locale": "en-GB", "viewport": viewport, **self.options}


PHONE: Final = Device(
    "phone", (UPRIGHT, ACROSS), {"has_touch": True, "is_mobile": True, "device_scale_factor": 2}
)
COMPUTER: Final = Device("desktop", (DESKTOP,), {})
DEVICES: Final = (COMPUTER, PHONE)


@dataclass(frozen=True, slots=True)
class View:
    size: Size
    theme: Theme

    @property
    def key(self) -> str:
        return f"{self.size.key}-{self.theme}"

    @property
    def device(self) -> Device:
        return next(device for device in DEVICES if self.size in device.sizes)

    async def show(self, page: Page) -> None:
        """Turn the phone and switch the theme, as a person does while the page is open."""
        await page.set_viewport_size({"width": self.size.width, "height": self.size.height})
        await page.emulate_media(color_scheme=self.theme)
        await page.evaluate(_SETTLED)
