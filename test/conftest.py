"""Says of each test that was run again how it failed the first time: such a test is a defect to be mended."""

from __future__ import annotations

from typing import Any


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """The first failures of tests that were run a second time, whatever became of them then."""
    for report in terminalreporter.getreports("rerun"):
        terminalreporter.section(f"{report.nodeid} was run again; it had failed so:", sep="-")
        terminalreporter.write_line(report.longreprtext)
