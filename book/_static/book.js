/* One switch shows the code of drawings, tables and controls. Sources are handed over, not shown. What scrolls sideways can be reached by keyboard: wide formulas and code get a place in the tab order. */
(() => {
  "use strict";
  const boxes = "mjx-container[display='true'], .bd-article div.math, .bd-article .rp-source .highlight, .bd-article .cell_input pre, .bd-article .text_html";

  const machinery = "div.cell.tag_hide-input:not(.tag_fold) > details.hide.above-input";

  let screenTheme = "light";

  function offerCode() { // what a reader need not see to follow is shown when asked for
    const folds = document.querySelectorAll(machinery);
    const place = document.querySelector(".article-header-buttons");
    if (!folds.length || !place) return;
    const button = document.createElement("button");
    button.type = "button";
    button.className = "btn btn-sm rp-all-code";
    button.title = `Show the code of drawings, tables and controls, too (${folds.length} cells)`;
    button.innerHTML = '<span aria-hidden="true">&lt;/&gt;</span> <span>All code</span>';
    const show = (all) => {
      document.documentElement.classList.toggle("rp-with-code", all);
      button.setAttribute("aria-pressed", String(all));
      for (const fold of folds) fold.open = all;
    };
    button.addEventListener("click", () => {
      const all = button.getAttribute("aria-pressed") !== "true";
      remember(all);
      show(all);
    });
    place.prepend(button);
    show(remember());
  }

  function remember(all) { // from page to page, where a browser lets a page keep something
    try {
      if (all !== undefined) localStorage.setItem("rp-all-code", all ? "1" : "");
      return localStorage.getItem("rp-all-code") === "1";
    } catch {
      return false;
    }
  }

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
    offerCode();
    mark();
    addEventListener("resize", mark);
    document.addEventListener("toggle", measure, true);
    globalThis.MathJax?.startup?.promise?.then(() => document.fonts.ready).then(measure);
  });
})();
