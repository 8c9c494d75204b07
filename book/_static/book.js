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

  function measure() { // a wide formula is set smaller by the style sheet
    for (const box of document.querySelectorAll(".bd-article div.math mjx-container[display='true']:not(.rp-wide)")) {
      const size = parseFloat(getComputedStyle(box).fontSize);
      const letters = box.firstElementChild.getBoundingClientRect().width / size;
      if (letters < 15) continue; // it fits, or it is folded
      box.style.setProperty("--rp-size", `${size}px`);
      box.style.setProperty("--rp-letters", (letters + 0.2).toFixed(2));
      box.classList.add("rp-wide");
    }
    mark();
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
    document.addEventListener("toggle", measure, true);
    globalThis.MathJax?.startup?.promise?.then(() => document.fonts.ready).then(measure);
  });
})();
