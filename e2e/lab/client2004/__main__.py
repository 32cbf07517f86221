"""``python -m e2e.lab.client2004``: what the thesis heard beside what the model hears."""

from __future__ import annotations

from e2e.lab.client2004.table import text

if __name__ == "__main__":
    print(text())
