"""What axe finds on a page; of texts with the same colours one is judged, as that takes long."""

from typing import Any

from axe_playwright_python.base import AXE_SCRIPT
from playwright.sync_api import Page

DISTINCT = """
() => {
  const known = new Map();
  const surroundings = (node) => { // what of an element and those around it makes its colours
    if (!node) return "";
    if (known.has(node)) return known.get(node);
    const style = getComputedStyle(node);
    const around = surroundings(node.parentElement);
    const over = style.zIndex !== "auto" || /absolute|fixed|sticky/.test(style.position);
    const own = [
      style.backgroundColor, style.backgroundImage, style.opacity, style.filter, style.transform,
      style.mixBlendMode, node.matches(":disabled, [aria-disabled='true'], label"),
    ].join();
    const plain = "rgba(0, 0, 0, 0),none,1,none,none,normal,false";
    const found = around === null || over ? null : own === plain ? around : `${around};${own}`;
    known.set(node, found); // null: it may lie over something else, so it is like no other
    return found;
  };
  const others = new Set();
  return [...document.body.querySelectorAll("*")].filter((node) => {
    if (node.closest(".rp-svg, mjx-assistive-mml")) return false; // the latter is for ears
    if (node.matches("input, select, textarea")) return true;
    const texts = [...node.childNodes].filter((child) => child.nodeType === Node.TEXT_NODE);
    const length = texts.map((text) => text.data.trim()).join("").length;
    if (!length || !node.checkVisibility({ visibilityProperty: true })) return false;
    const around = surroundings(node);
    if (around === null) return true;
    const { color, fontSize, fontWeight, textShadow } = getComputedStyle(node);
    const looks = [around, color, fontSize, fontWeight, textShadow, length === 1].join(";");
    return !others.has(looks) && others.add(looks);
  });
}
"""
"""Elements with text: all that may lie over something, of others one of each look."""

RUN = f"""
async (options) => {{
  const judged = ({DISTINCT})();
  axe.configure({{ rules: [{{ id: "color-contrast", selector: "[data-judged]" }}] }});
  for (const node of judged) node.dataset.judged = "";
  const exclude = [[".rp-svg > *"]]; // a figure is one image with a name
  const found = await axe.run({{ exclude }}, options);
  for (const node of judged) delete node.dataset.judged;
  return found.violations;
}}
"""


def violations(page: Page, theme: str = "light") -> list[dict[str, Any]]:
    """Return what axe finds; in the dark, of colours alone."""
    options: dict[str, Any] = {"preload": False, "resultTypes": ["violations"]}
    if theme == "dark":
        options["runOnly"] = {"type": "rule", "values": ["color-contrast", "link-in-text-block"]}
    page.evaluate(AXE_SCRIPT)
    return page.evaluate(RUN, options)


def serious(violations: list[dict[str, Any]]) -> list[str]:
    """Return the findings of axe of serious or critical impact, a line each."""
    return [
        f"{v['impact']}: {v['id']} ({v['help']}) at {node['target']}: {node['html'][:160]}"
        for v in violations
        if v["impact"] in ("serious", "critical")
        for node in v["nodes"]
    ]
