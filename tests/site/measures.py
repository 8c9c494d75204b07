"""What is measured inside a page: scripts that return what is wrong with it, in words."""

SMALLEST_PX = 10

SETTLED = """
async () => {
  const frame = () => new Promise(requestAnimationFrame);
  for (let number = 0; number < 3; number++) await frame(); // observers and listeners have run
  const ends = (move) => Number.isFinite(move.effect.getComputedTiming().endTime);
  for (const move of document.getAnimations().filter(ends)) move.finish();
  await frame();
}
"""
"""Waits until a page has taken another size or theme."""

IDLE = """
async (root) => {
  const busy = () => root.matches("[data-busy]") || root.querySelector(".explorer[data-busy]");
  for (const end = performance.now() + 60_000; busy();) {
    if (performance.now() > end) throw new Error("an explorer has been busy for a minute");
    await new Promise((resolve) => setTimeout(resolve, 5));
  }
}
"""
"""Waits until an explorer, or all inside of an element, show what they were asked for."""

REST = f"""
async () => {{
  for (const reset of document.querySelectorAll(".rp-reset")) reset.click();
  await ({IDLE})(document.body);
  await ({SETTLED})();
}}
"""
"""Resets all explorers."""

EQUATIONS = """
() => {
  const folds = [...document.querySelectorAll("details:not([open])")];
  for (const fold of folds) fold.open = true;
  const found = [];
  for (const box of document.querySelectorAll(".bd-article div.math")) {
    const column = box.parentElement;
    const style = getComputedStyle(column);
    const [before, after] = [style.paddingLeft, style.paddingRight].map(parseFloat);
    const left = column.getBoundingClientRect().left + column.clientLeft + before;
    const room = column.clientWidth - before - after;
    const number = box.querySelector("mjx-labels"); // at the edge, beside a table of one row
    const formulas = number ? [number.parentElement.querySelector("mjx-itable")]
      : box.querySelectorAll("mjx-math, math > *"); // without scripts, MathML
    const edges = [...formulas].map((formula) => formula.getBoundingClientRect());
    const first = Math.min(...edges.map((edge) => edge.left)) - left;
    const last = Math.max(...edges.map((edge) => edge.right)) - left;
    const off = last - first > room ? first : (first + last - room) / 2;
    const place = box.textContent.slice(0, 80);
    if (!(Math.abs(off) <= 3)) found.push(`${off.toFixed()} px off: ${place}`);
  }
  for (const fold of folds) fold.open = false;
  return found;
}
"""
"""Displayed equations that are not in the middle of their column; a wide one must begin with it."""

ALIGNED = r"""
() => [...document.querySelectorAll("table.rp-results")].flatMap((table) => {
  const heads = [...table.tHead.rows[0].cells];
  const names = heads.map((head) => head.textContent);
  return heads.flatMap((head, place) => {
    const cells = [...table.tBodies[0].rows].map((row) => row.cells[place]);
    const texts = cells.map((cell) => cell.textContent);
    const sentence = texts.some((text) => /[a-z]{2}.* [a-z]{2}/i.test(text));
    const words = !place || sentence || names.includes("ours");
    const numbers = texts.every((text) => /^(–|−?[\d.]*( \[[^\]]*\])?)$/.test(text));
    if (words === numbers) return []; // a word among numbers, or numbers that are texts
    const side = words ? "left" : "right";
    const wrong = [head, ...cells].filter((cell) => getComputedStyle(cell).textAlign !== side);
    return wrong.map((cell) => `${names[place]}, not at the ${side}: ${cell.textContent}`);
  });
})
"""
"""Cells of tables whose words are not flush left, or numbers not flush right, in a window."""

WIDE_ELEMENTS = """
() => {
  const width = document.documentElement.clientWidth;
  const held = (node) => {
    for (let box = node; box && box !== document.body; box = box.parentElement) {
      const style = getComputedStyle(box);
      if (style.position === "fixed") return true;
      if (box !== node && style.overflowX !== "visible") return true;
    }
    return false;
  };
  const wide = [...document.querySelectorAll("main *")].filter((node) => {
    const box = node.getBoundingClientRect();
    return box.width > 1 && box.height > 1 && box.right > width + 1 && !held(node);
  });
  const page = document.documentElement.scrollWidth;
  const names = wide.map((node) => node.outerHTML.slice(0, 120));
  return page > width ? [`the page is ${page} px wide`, ...names] : names;
}
"""
"""What is wider than the window, and not in a box of its own that scrolls."""

SIDEWAYS = """
(selector) => [...document.querySelectorAll(selector)].filter(
  (box) => box.checkVisibility() && box.scrollWidth > box.clientWidth + 1
).map((box) => `${box.scrollWidth} px in ${box.clientWidth}: ${box.textContent.slice(0, 200)}`)
"""
"""Boxes of a kind whose content has to be moved sideways to be read."""

LETTERS = """
([smallest, within]) => {
  const found = [];
  for (const picture of within.querySelectorAll(".rp-svg")) {
    const named = picture.closest("[aria-label]");
    const place = picture.closest("figure")?.id || named.getAttribute("aria-label").slice(0, 60);
    const tell = (words) => found.push(`${place}: ${words}`);
    const canvas = picture.closest(".rp-canvas")?.getBoundingClientRect(); // it cuts off
    const [first, last] = canvas ? [canvas.left - 0.5, canvas.right + 0.5] : [0, innerWidth];
    const others = [];
    for (const text of picture.querySelectorAll("text")) {
      const box = text.getBoundingClientRect();
      const words = text.textContent;
      if (!words.trim() || !box.width) continue;
      const { a, b } = text.getScreenCTM();
      const size = parseFloat(getComputedStyle(text).fontSize) * Math.hypot(a, b);
      if (size < smallest - 0.05) tell(`${words} has ${size.toFixed(1)} px`);
      if (box.left < first || box.right > last) tell(`${words} leaves the window`);
      const lying = Math.abs(a) > Math.abs(b); // above and below letters a line has room
      const [x, y] = lying ? [2, 0.16 * box.height] : [0.1 * box.width, 2];
      const own = [box.left + x, box.right - x, box.top + y, box.bottom - y, words];
      for (const [left, right, top, bottom, name] of others) {
        const apart = own[0] >= right || left >= own[1] || own[2] >= bottom || top >= own[3];
        if (!apart) tell(`${words} and ${name} overlap`);
      }
      others.push(own);
    }
    for (const outline of picture.querySelectorAll("use")) { // letters of formulas, 100 units high
      if (!/DejaVu|STIX|cmr/.test(outline.getAttribute("xlink:href"))) continue;
      const { a, b } = outline.getScreenCTM();
      const size = 100 * Math.hypot(a, b); // raised letters have 0.7 of it
      if (size < 0.69 * smallest) tell(`a formula has letters of ${size.toFixed(1)} px`);
    }
  }
  return found;
}
"""
"""Letters of drawings that are smaller than so many pixels, overlap, or leave the window."""

LETTERS_IN_PRESETS = f"""
async (smallest) => {{
  const [letters, idle] = [{LETTERS}, {IDLE}];
  const found = letters([smallest, document.querySelector("main")]);
  for (const preset of document.querySelectorAll(".rp-preset")) {{
    const root = preset.closest(".explorer");
    preset.click();
    await idle(root);
    found.push(...letters([smallest, root]));
  }}
  return [...new Set(found)].sort();
}}
"""
"""The same, in presets too."""

TOGETHER = """
() => [...document.querySelectorAll("div.explorer")].map((root) => {
  const canvas = root.querySelector(".rp-canvas").getBoundingClientRect();
  const controls = root.querySelector(".rp-controls").getBoundingClientRect();
  const header = document.querySelector(".bd-header-article")?.getBoundingClientRect().height ?? 0;
  const height = controls.bottom - canvas.top + header;
  return { name: root.querySelector("figure").id || root.id, height };
})
"""
"""How high each explorer is with its controls, below the header."""

TOPS = """
() => [...document.querySelectorAll(".rp-row")].map(
  (row) => [...row.children].map((child) => Math.round(child.getBoundingClientRect().top)))
"""
"""Where the drawings of each row begin."""

ROWS = """
() => [...document.querySelectorAll("table.rp-results")]
  .filter((table) => !table.closest("details"))
  .map((table) => table.tBodies[0].rows.length)
"""
"""How many rows each table of results has outside of folds."""

COLUMNS = """
() => [...document.querySelectorAll("div.cell_output div.output > div.highlight pre")].filter(
  (text) => text.scrollWidth > text.clientWidth + 1 || getComputedStyle(text).whiteSpace !== "pre"
).map((text) => text.textContent.slice(0, 200))
"""
"""Printed outputs whose lines are not whole."""

UNSET = r"""
() => [...document.querySelectorAll(".math")].filter((formula) => {
  const box = formula.querySelector("math")?.getBoundingClientRect();
  const set = box?.width && box.height && !/[\\&]/.test(formula.innerText);
  return formula.checkVisibility() && !set;
}).map((formula) => formula.textContent)
"""
"""Formulas that MathML does not set, or that show LaTeX."""

SOURCE = r"""
() => [...document.querySelectorAll("p, li, td, th, dt, dd, legend, label, figcaption, h1, h2, h3")]
  .filter((text) => text.checkVisibility() && /\\[(\[]/.test(text.innerText))
  .map((text) => text.innerText)
"""
"""Texts that show LaTeX."""
