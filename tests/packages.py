"""Third-party packages, installed where Python finds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


def install(
    folder: Path,
    name: str,
    offers: Mapping[str, Mapping[str, str]],
    *,
    modules: Mapping[str, str] | None = None,
    needs: Mapping[str, str] | None = None,
) -> None:
    """Put a package's files into `folder`, as pip would.

    `offers` are its entry points by group, `modules` their text by name, and `needs` the package
    that each of its extras requires.
    """
    info = folder / f"{name.replace('-', '_')}-1.2.dist-info"
    info.mkdir()
    extras = "".join(
        f'Provides-Extra: {extra}\nRequires-Dist: {package}>=1; extra == "{extra}"\n'
        for extra, package in (needs or {}).items()
    )
    (info / "METADATA").write_text(f"Metadata-Version: 2.4\nName: {name}\nVersion: 1.2\n{extras}")
    (info / "entry_points.txt").write_text(
        "".join(
            f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in points.items())
            for group, points in offers.items()
        )
    )
    for module, text in (modules or {}).items():
        (folder / f"{module}.py").write_text(text)
