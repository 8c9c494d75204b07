/* Sources are handed over, not shown. What scrolls sideways can be reached by keyboard: wide formulas and code get a place in the tab order. */
(() => {
  "use strict";
  const boxes = "mjx-container[display='true'], .bd-article div.math, .bd-article .rp-source .highlight, .bd-article .text_html";

  let screenTheme = "light";

  function mark() {
    for (const box of document.querySelectorAll(boxes)) {
      if (box.scrollWidth > box.clientWidth + 1) box.tabIndex = 0;
      else box.removeAttribute("tabindex");
    }
  }

  matchMedia("print").addEventListener("change", ({ matches: printing }) => { // paper is light
    const page = document.documentElement.dataset;
    if (printing) screenTheme = page.theme;
    page.theme = printing ? "light" : screenTheme;
  });

  addEventListener("load", () => {
    document.querySelectorAll("a.btn-download-source-button").forEach((link) => { link.download = ""; });
    mark();
    addEventListener("resize", mark);
    globalThis.MathJax?.startup?.promise?.then(() => document.fonts.ready).then(mark);
  });
})();
