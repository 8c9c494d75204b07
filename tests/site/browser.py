"""A real browser for the tests: the system's Chromium, without any talk of its own."""

import shutil

from playwright.sync_api import Browser, Playwright

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
WINDOW = {"width": 1280, "height": 800}
TELEPHONE = {"width": 390, "height": 844}
PATIENCE_MS = 120_000
"""For a page to open on a machine that is busy; no test asserts a time."""


def executable() -> str | None:
    """Return the path of the system's Chromium, or None."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


def launch(playwright: Playwright) -> Browser | None:
    """Start the system's Chromium with a fresh profile, or return None if there is none."""
    path = executable()
    return playwright.chromium.launch(executable_path=path, args=list(FLAGS)) if path else None
