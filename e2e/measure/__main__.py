"""``python -m e2e.measure``: render the README's tables, and say which of their rows are stale."""

from __future__ import annotations

import sys

from e2e.measure.errors import MeasureError
from e2e.measure.published import load
from e2e.measure.readme import rendered
from e2e.measure.suite import ROOT
from e2e.measure.table import to_markdown


def main() -> int:
    readme = ROOT / "README.md"

    def table(suite: str) -> str:
        published = load(suite)
        if published.is_stale:
            print(f"{suite}: stale, measured on {published.commit}", file=sys.stderr)
        return to_markdown(published, is_stale=published.is_stale)

    try:
        readme.write_text(rendered(readme.read_text(encoding="utf-8"), table), encoding="utf-8")
    except MeasureError as error:
        print(f"figures: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
