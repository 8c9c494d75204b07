"""Drives an explorer the way a reader does, on a built page or in JupyterLab."""

from collections.abc import Mapping
from itertools import product
from math import dist
from typing import Any

from playwright.sync_api import ElementHandle, Page

from tests.site.measures import IDLE

SHOWN = r"""
async (root) => {
  const bytes = async (src) => src.startsWith("blob:")
    ? new TextDecoder("latin1").decode(await (await fetch(src)).arrayBuffer()) : src;
  const canvas = root.querySelector(".rp-canvas");
  const image = canvas.querySelector("img");
  if (image) await image.decode();
  const node = image ?? canvas.firstElementChild; // a drawing, or a row of them
  const shown = image ? await bytes(image.src) : node.outerHTML;
  const drawn = image ? "" : shown.replace(/base64,[^"]*/g, "");
  const seen = (globalThis.picturesSeen ??= new Map());
  if (!seen.has(shown)) seen.set(shown, seen.size);
  const complaint = root.querySelector(".rp-error:not([hidden])")?.textContent ?? "";
  const { width, height } = node.getBoundingClientRect();
  return {
    picture: seen.get(shown), // its number among all that were seen on this page
    alt: image ? image.alt : node.getAttribute("aria-label"),
    marks: image ? image.naturalWidth : node.querySelectorAll("path, use, image, text").length,
    area: width * height,
    finite: !/(?<![\w-])(?:nan|inf|infinity)(?![\w-])/i.test(drawn),
    complaint,
  };
}
"""
PICTURE = f"""
async (root) => {{
  await ({IDLE})(root);
  return ({SHOWN})(root);
}}
"""
"""Waits for the picture of an explorer, and returns what it is like."""
MIDDLE = """
(node) => {
  const { x, y, width, height } = node.getBoundingClientRect();
  return [x + width / 2, y + height / 2];
}
"""
ARROWS = {"ArrowLeft": (-1, 0), "ArrowRight": (1, 0), "ArrowUp": (0, -1), "ArrowDown": (0, 1)}
HELD_MS = 600


def faults(seen: Mapping[str, Any]) -> list[str]:
    """Return what is wrong with a picture that was looked at."""
    sound = {
        seen["complaint"]: not seen["complaint"],
        "the picture has no size": seen["area"] > 1000,
        "the picture is empty": seen["marks"] > 0,
        f"alternative text {seen['alt']!r}": len(seen["alt"] or "") >= 20,
        "the picture holds a number that is not finite": seen["finite"],
    }
    return [words for words, holds in sound.items() if not holds]


class Driver:
    """Drives one explorer the way a reader does, looks at every picture, notes what is wrong."""

    def __init__(self, page: Page, root: ElementHandle) -> None:
        self.page = page
        self.root = root
        self.name = root.query_selector("figure").get_attribute("id") or root.get_attribute("id")
        self.controls = root.query_selector_all(".rp-control")
        self.grip = root.query_selector(".rp-grip")
        self.pictures: set[int] = set()
        self.states = 0
        self.wrong: list[str] = []
        self.look()

    def demand(self, holds: bool, words: str) -> None:
        """Note what is wrong, once, unless something holds."""
        if not holds and words not in self.wrong:
            self.wrong.append(words)

    def look(self) -> int:
        """Return the number of the picture that is shown, after judging it."""
        seen = self.page.evaluate(PICTURE, self.root)
        for fault in faults(seen):
            self.demand(False, fault)
        self.pictures.add(seen["picture"])
        self.states += 1
        return seen["picture"]

    def drive(self, control: ElementHandle) -> None:
        """Move one control to each of its ends, by the keyboard where it has keys."""
        before = len(self.pictures)
        if slider := control.query_selector("input[type=range]"):
            for key in ("Home", "End", "ArrowLeft"):
                self._press(slider, key)
            self.demand(bool(slider.get_attribute("aria-valuetext")), "a slider has no words")
        elif select := control.query_selector("select"):
            for index in range(len(select.query_selector_all("option"))):
                select.select_option(index=index)
                self.look()
        elif box := control.query_selector("input[type=checkbox]"):
            for _ in range(2):
                self._press(box, "Space")
        else:
            radios = control.query_selector_all("input[type=radio]")
            radios[0].check()
            for radio in [*radios[1:], radios[0]]:
                self._press(radio, "Space")
        moved = len(self.pictures) > before or len(self.pictures) > 1
        self.demand(moved, "nothing moves the picture")

    def drive_all(self) -> None:
        """Drive every control and press every button; reset leads back each time."""
        self.reset()
        start = self.look()
        for control in self.controls:
            self.drive(control)
            self.reset()
        for preset in self.root.query_selector_all(".rp-preset"):
            preset.click()
            self.look()
            self.demand(preset.get_attribute("aria-pressed") == "true", "a preset is not pressed")
        self.reset()
        self.demand(self.look() == start, "reset does not lead back to the start")

    def drag(self) -> None:
        """Take the point to the nearest state by the mouse, and back by reset."""
        self.reset()
        self.grip.scroll_into_view_if_needed()
        start, before = self.settings(), self.look()
        x, y = self._place()
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for far, right, down in product((60, 120, 180), (1, 0, -1), (1, 0, -1)):
            self.page.mouse.move(x + far * right, y + far * down, steps=2)
            self.look()
            if self.settings() != start:
                break
        self.page.mouse.up()
        self.demand(self.settings() != start, "nothing is dragged")
        self.demand(self.look() != before, "the picture does not follow the point")
        self.turn()
        self.demand("arrow keys" in self.grip.get_attribute("aria-label"), "no word of arrow keys")
        self.reset()
        self.grip.scroll_into_view_if_needed()
        self.demand(dist(self._place(), (x, y)) <= 1, "reset leaves the grip behind")

    def turn(self) -> None:
        """Move the point by arrow keys, each to the next state in its direction."""
        turned = 0
        for key, (right, down) in ARROWS.items():
            (x, y), old = self._place(), self.settings()
            self._press(self.grip, key)
            if self.settings() == old:
                continue
            now, turned = self._place(), turned + 1
            ahead = right * (now[0] - x) + down * (now[1] - y)
            self.demand(ahead > 0, f"{key} does not lead in its direction")
        self.demand(turned > 0, "no arrow moves the point")

    def play(self, control: ElementHandle) -> None:
        """Let time run: nothing moves before play is pressed, or after pause."""
        slider, play = (control.query_selector(kind) for kind in ("input[type=range]", ".rp-play"))
        self._press(slider, "Home")
        self.demand(play.inner_text() == "Play", "it plays by itself")
        play.click()
        self.demand(play.inner_text() == "Pause", "it does not play")
        self.page.wait_for_function(
            "(slider) => Number(slider.value) >= 2", arg=slider, timeout=15_000
        )
        play.click()
        self.demand(play.inner_text() == "Play", "it does not pause")
        held = slider.input_value()
        self.page.wait_for_timeout(HELD_MS)
        self.demand(slider.input_value() == held, "time goes on while it pauses")

    def reset(self) -> None:
        """Press the reset button."""
        self.root.query_selector(".rp-reset").click()
        self.look()

    def settings(self) -> list[str]:
        """Return the values at which the sliders stand."""
        sliders = self.root.query_selector_all("input[type=range]")
        return [slider.get_attribute("aria-valuetext") for slider in sliders]

    def status(self) -> str:
        """Return what a screen reader is told."""
        return self.root.query_selector(".rp-status").text_content()

    def _press(self, node: ElementHandle, key: str) -> None:
        node.focus()
        self.page.keyboard.press(key)
        self.look()

    def _place(self) -> tuple[float, float]:
        """Return where the middle of the grip is, pixels of the page."""
        return tuple(self.grip.evaluate(MIDDLE))


def drivers(page: Page) -> list[Driver]:
    """Return a driver for every explorer of an open page."""
    roots = page.query_selector_all("div.explorer")
    for root in roots:
        assert root.query_selector(".rp-controls"), "an explorer has no controls"
    return [Driver(page, root) for root in roots]
