"""The report: turns the suite's results into one page that repeats chapter 5."""

from e2e.delay.report.page import write

__all__ = ["write"]
