"""Drives an explorer the way a reader does, on a built page or in JupyterLab."""

import re

from playwright.sync_api import ElementHandle, Page

PICTURE = """
async (root) => {
  const pause = () => new Promise((resolve) => setTimeout(resolve, 5));
  while (root.hasAttribute("data-busy")) await pause();
  const bytes = async (src) => src.startsWith("blob:")
    ? new Uint8Array(await (await fetch(src)).arrayBuffer()).join() : src;
  const canvas = root.querySelector(".rp-canvas");
  const image = canvas.querySelector("img");
  if (image) await image.decode();
  const node = image ?? canvas.firstElementChild; // a drawing, or a row of them
  const complaint = root.querySelector(".rp-error:not([hidden])")?.textContent ?? "";
  const { width, height } = node.getBoundingClientRect();
  return {
    picture: image ? await bytes(image.src) : node.outerHTML,
    alt: image ? image.alt : node.getAttribute("aria-label"),
    marks: image ? image.naturalWidth : node.querySelectorAll("path, use, image, text").length,
    area: width * height,
    complaint,
  };
}
"""
NOT_FINITE = re.compile(r"(?<![\w-])(?:nan|inf|infinity)(?![\w-])", re.IGNORECASE)
EMBEDDED = re.compile(r'base64,[^"]*|^http.*')


class Driver:
    """Drives one explorer the way a reader does, and looks at every picture."""

    def __init__(self, page: Page, root: ElementHandle) -> None:
        self.page = page
        self.root = root
        self.controls = root.query_selector_all(".rp-control")
        self.pictures: set[str] = set()
        self.states = 0
        self.look()

    def look(self) -> str:
        """Return the picture that is shown, after judging it."""
        seen = self.page.evaluate(PICTURE, self.root)
        assert not seen["complaint"], seen["complaint"]
        assert seen["area"] > 1000, "the picture has no size"
        assert seen["marks"] > 0, "the picture is empty"
        assert len(seen["alt"]) >= 20, f"alternative text {seen['alt']!r}"
        drawn = EMBEDDED.sub("", seen["picture"])
        assert not NOT_FINITE.search(drawn), "the picture holds a number that is not finite"
        self.pictures.add(seen["picture"])
        self.states += 1
        return seen["picture"]

    def drive(self, control: ElementHandle) -> None:
        """Move one control to each of its ends, by the keyboard where it has keys."""
        before = len(self.pictures)
        if slider := control.query_selector("input[type=range]"):
            for key in ("Home", "End", "ArrowLeft"):
                slider.focus()
                self.page.keyboard.press(key)
                self.look()
            assert slider.get_attribute("aria-valuetext")
        elif select := control.query_selector("select"):
            for index in range(len(select.query_selector_all("option"))):
                select.select_option(index=index)
                self.look()
        elif box := control.query_selector("input[type=checkbox]"):
            for _ in range(2):
                box.focus()
                self.page.keyboard.press("Space")
                self.look()
        else:
            radios = control.query_selector_all("input[type=radio]")
            radios[0].check()
            for radio in [*radios[1:], radios[0]]:
                radio.focus()
                self.page.keyboard.press("Space")
                self.look()
        assert len(self.pictures) > before or len(self.pictures) > 1, "nothing moves the picture"

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


def drivers(page: Page) -> list[Driver]:
    """Return a driver for every explorer of an open page."""
    roots = page.query_selector_all("div.explorer")
    for root in roots:
        assert root.query_selector(".rp-controls"), "an explorer has no controls"
    return [Driver(page, root) for root in roots]
