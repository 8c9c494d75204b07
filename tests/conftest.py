"""The summary of the site tests, over all workers; below `site` pytest would not look for it."""

from collections import Counter

from tests.site.counts import COUNTS


def pytest_terminal_summary(terminalreporter: object) -> None:
    """Print what was seen of the site, over all workers."""
    totals: Counter[str] = Counter()
    seen = False
    for reports in terminalreporter.stats.values():
        for report in reports:
            for name, value in getattr(report, "user_properties", ()):
                if name.startswith("site: ") and getattr(report, "when", "") == "call":
                    totals[name.removeprefix("site: ")] += value
                    seen = True
    if not seen:
        return
    terminalreporter.section("the built site in Chromium")
    for name in COUNTS:
        terminalreporter.write_line(f"{totals[name]:6d}  {name}")
