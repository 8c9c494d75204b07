"""What holds for all tests: no deadlines for examples; the summary of the site over all workers."""

from collections import Counter

from hypothesis import settings

from tests.site.counts import COUNTS

settings.register_profile("book", settings(), deadline=None)  # no test asserts a time
settings.load_profile("book")


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
