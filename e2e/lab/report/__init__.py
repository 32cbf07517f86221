"""The report: from the suite's results to one page that says chapter 5 anew."""

from e2e.lab.report.page import write

__all__ = ["write"]
