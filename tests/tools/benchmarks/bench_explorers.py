"""Moving one control of each explorer: in a real JupyterLab, and on the built page, in Chromium.

Measured inside the page, from the input event to the frame after the new picture is in place.
"""

import os
import statistics
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from tests.site import extra
from tests.site.browser import launch
from tests.site.lab import jupyterlab
from tests.tools.benchmarks.harness import Timing

ROOT = Path(__file__).parents[3]
BOOK = ROOT / "book"
EXPLORER = '<div class="explorer"'
MOVES = 16
MEDIAN_S = {"in JupyterLab": 0.08, "built page": 0.05}
LONGEST_S = 0.3

MOVE = """
async ([explorer, moves]) => {
  const canvas = explorer.querySelector(".rp-canvas");
  const control = explorer.querySelector(".rp-control");
  const input = control.querySelector("input[type=range], select, input[type=checkbox]")
    ?? control.querySelector("input[type=radio]:not(:checked)");
  const picture = () => canvas.querySelector("img")?.src ?? canvas.innerHTML;
  function turn(k) {
    if (input.type === "radio") {
      return control.querySelector("input[type=radio]:not(:checked)").click();
    }
    if (input.type === "checkbox") return input.click();
    if (input.tagName === "SELECT") input.selectedIndex = k % input.options.length;
    else input.value = k % 2 ? input.min : Number(input.max) - k % Number(input.max);
    input.dispatchEvent(new Event(input.type === "range" ? "input" : "change", { bubbles: true }));
  }
  const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const idle = async () => { while (explorer.hasAttribute("data-busy")) await pause(2); };
  const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const durations = [];
  for (let k = 0; k < moves; k++) {
    await idle();
    await pause(30);
    const before = picture();
    const painted = new Promise((resolve) => {
      const observer = new MutationObserver(() => { observer.disconnect(); resolve(true); });
      observer.observe(canvas, { childList: true, subtree: true, attributes: true });
      setTimeout(() => { observer.disconnect(); resolve(false); }, 10000);
    });
    const start = performance.now();
    turn(k);
    if (await painted) {
      await frame();
      if (picture() !== before) durations.push(performance.now() - start);
    }
  }
  return durations;
}
"""


def rows() -> list[Timing]:
    """Measure every explorer of every chapter, and of the page of pictures, in both media."""
    site = Path(os.environ.get("ROBOT_PERCEPTION_SITE", ROOT / "build/_build/html")).resolve()
    pages = {chapter: site / f"{chapter.stem}.html" for chapter in sorted(BOOK.glob("*.ipynb"))}
    if missing := [page.name for page in pages.values() if not page.exists()]:
        raise RuntimeError(f"build the book first: {site} has no {', '.join(missing)}")
    built = {c: page for c, page in pages.items() if EXPLORER in page.read_text("utf-8")}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        built[extra.HERE / "pictures.ipynb"] = extra.build("pictures", Path(folder))
        browser = launch(playwright)
        if browser is None:
            return []
        page = browser.new_page()
        found: list[Timing] = []
        with jupyterlab(list(built)) as lab:
            for notebook in built:
                lab.open(page, notebook.name)
                lab.run_all(page, notebook.name)
                for label, moves in moves_on(page):
                    found.append(_timing(f"{notebook.stem}, {label}", "in JupyterLab", moves))
        for notebook, html in built.items():
            page.goto(html.as_uri())
            page.wait_for_load_state("load")
            for label, moves in moves_on(page):
                found.append(_timing(f"{notebook.stem}, {label}", "built page", moves))
        browser.close()
    return found


def moves_on(page: Page) -> list[tuple[str, list[float]]]:
    """Move the first control of every explorer of an open page: its label, seconds of each move."""
    explorers = page.query_selector_all("div.explorer:has(.rp-controls)")
    if not explorers:
        raise RuntimeError(f"no explorer is alive on {page.url}")
    found = []
    for explorer in explorers:
        label = explorer.eval_on_selector(".rp-control :is(.rp-name, label)", "e => e.textContent")
        explorer.scroll_into_view_if_needed()
        page.evaluate(MOVE, [explorer, 2])  # the first moves load what is needed
        milliseconds = page.evaluate(MOVE, [explorer, MOVES])
        complaint = explorer.eval_on_selector(".rp-error", "e => e.hidden ? '' : e.textContent")
        if complaint or not milliseconds:
            raise RuntimeError(f"{label!r} on {page.url}: {complaint or 'no picture moved'}")
        if any(label == other for other, _ in found):
            label = f"{label} of explorer {len(found) + 1}"
        found.append((label, [duration / 1e3 for duration in milliseconds]))
    return found


def _timing(work: str, where: str, moves: list[float]) -> Timing:
    median, longest, median_s = statistics.median(moves), max(moves), MEDIAN_S[where]
    return Timing(
        work=f"{work}, {where} ({len(moves)} moves, longest {longest * 1e3:.0f} ms)",
        ours_s=median,
        peer_s=None,
        peer_name="",
        target=f"median ≤ {median_s * 1e3:g} ms, none above {LONGEST_S * 1e3:g} ms",
        reached=median <= median_s and longest <= LONGEST_S,
    )
