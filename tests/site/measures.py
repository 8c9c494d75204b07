"""What is measured inside a page: scripts that return what is wrong with it, in words."""

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
