"""``python -m e2e.measure``: render the tables, and say which suites are older than the product."""

from __future__ import annotations

import sys

from e2e.measure.errors import MeasureError
from e2e.measure.headline import HEADLINE, headline
from e2e.measure.published import FOLDER, load
from e2e.measure.readme import rendered
from e2e.measure.suite import ROOT
from e2e.measure.table import to_markdown


def main() -> int:
    def table(suite: str) -> str:
        if suite == HEADLINE:
            return headline()
        published = load(suite)
        if published.is_stale:
            print(f"{suite}: the product has changed since {published.commit}", file=sys.stderr)
        return to_markdown(published, is_stale=published.is_stale)

    try:
        for readme in (ROOT / "README.md", FOLDER / "README.md"):
            text = readme.read_text(encoding="utf-8")
            readme.write_text(rendered(text, table), encoding="utf-8")
    except MeasureError as error:
        print(f"figures: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
