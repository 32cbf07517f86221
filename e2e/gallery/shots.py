"""Saves the gallery's pictures, and the page that shows them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from e2e.gallery.states import STATES
from e2e.gallery.views import DEVICES
from e2e.measure.command import OUT

if TYPE_CHECKING:
    from e2e.gallery.scene import Scene
    from e2e.gallery.states import State
    from e2e.gallery.views import View

FOLDER: Final = OUT / "gallery"
_TEMPLATES: Final = Path(__file__).parent / "templates"


async def shoot(scene: Scene, state: State, view: View) -> None:
    """Photograph the page as a person sees it, and print its accessibility tree."""
    place = FOLDER / state.key
    place.mkdir(parents=True, exist_ok=True)
    page = scene.viewer.page
    await page.screenshot(path=place / f"{view.key}.png", animations="disabled")
    tree = await page.locator("body").aria_snapshot()
    (place / f"{view.key}.yaml").write_text(tree + "\n", encoding="utf-8")


def write_page() -> None:
    """Write the page that shows everything in the folder."""
    loader = FileSystemLoader(_TEMPLATES)
    env = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    states = [(state, _shots(state)) for state in STATES]
    text = env.get_template("gallery.html").render(states=states)
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "index.html").write_text(text, encoding="utf-8")


def _shots(state: State) -> list[dict[str, str]]:
    """Return each picture, its address within the gallery, and what a screen reader reads there."""
    found = []
    for view in (view for device in DEVICES for view in device.views):
        picture = FOLDER / state.key / f"{view.key}.png"
        if picture.exists():
            tree = picture.with_suffix(".yaml").read_text(encoding="utf-8")
            title = f"{view.size.title}, {view.theme}"
            address = f"{state.key}/{picture.name}"
            found.append({"title": title, "picture": address, "tree": tree})
    return found
