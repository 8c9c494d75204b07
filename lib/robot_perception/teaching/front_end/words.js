/* What a word of the book means, beside its first use: on pointing, on focus, on a tap. Escape puts it away. */
(() => {
  "use strict";
  const DELAY = 120, GAP = 6;
  let note, shown, timer;

  function hide() {
    clearTimeout(timer);
    if (!shown) return;
    shown.removeAttribute("aria-describedby");
    shown = undefined;
    note.hidden = true;
  }

  function show(word) {
    clearTimeout(timer);
    if (shown === word) return;
    hide();
    shown = word;
    note.textContent = word.dataset.says;
    note.hidden = false;
    word.setAttribute("aria-describedby", note.id);
    const place = word.getClientRects()[0], size = note.getBoundingClientRect();
    const wide = document.documentElement.clientWidth;
    const left = Math.max(8, Math.min(place.left, wide - size.width - 8));
    const below = place.bottom + GAP + size.height < innerHeight || place.top < size.height + GAP;
    note.style.left = `${left + scrollX}px`;
    note.style.top = `${(below ? place.bottom + GAP : place.top - GAP - size.height) + scrollY}px`;
  }

  const later = (act) => { clearTimeout(timer); timer = setTimeout(act, DELAY); };

  addEventListener("DOMContentLoaded", () => {
    const words = document.querySelectorAll("a.rp-term");
    if (!words.length) return;
    note = document.createElement("div");
    note.id = "rp-says";
    note.className = "rp-says";
    note.setAttribute("role", "tooltip");
    note.hidden = true;
    document.body.append(note);
    let touched = false;
    for (const word of words) {
      word.dataset.says = word.title; // a browser's own note would stand above ours
      word.removeAttribute("title");
      word.addEventListener("pointerdown", ({ pointerType }) => { touched = pointerType === "touch" && shown !== word; });
      word.addEventListener("mouseenter", () => later(() => show(word)));
      word.addEventListener("mouseleave", () => later(hide));
      word.addEventListener("focus", () => show(word));
      word.addEventListener("blur", hide);
      word.addEventListener("click", (event) => { // the first tap shows, the second one follows
        if (touched) event.preventDefault();
        if (touched) show(word);
        touched = false;
      });
    }
    note.addEventListener("mouseenter", () => clearTimeout(timer)); // what is shown can be pointed at
    note.addEventListener("mouseleave", () => later(hide));
    addEventListener("keydown", ({ key }) => { if (key === "Escape") hide(); });
    addEventListener("pointerdown", ({ target }) => { if (shown && !target.closest?.(".rp-term, .rp-says")) hide(); });
  });
})();
