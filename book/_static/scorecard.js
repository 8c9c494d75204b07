/* The scorecard: claims chosen by verdict and by paper; a link to a claim shows and opens its card. */
"use strict";
addEventListener("DOMContentLoaded", () => {
  const board = document.querySelector(".rp-scorecard");
  if (!board) return;
  const form = board.querySelector(".rp-filter");
  const count = form.querySelector("[role=status]");
  const folds = form.querySelector("button");
  const cards = [...board.querySelectorAll(".rp-claim")];

  function choose() {
    const wanted = [...new FormData(form)].filter(([, value]) => value);
    for (const card of cards) card.hidden = wanted.some(([name, value]) => card.dataset[name] !== value);
    for (const chapter of board.querySelectorAll("section")) {
      chapter.hidden = !chapter.querySelector(".rp-claim:not([hidden])");
    }
    count.textContent = `${cards.filter((card) => !card.hidden).length} of ${cards.length} claims`;
  }

  function show() {
    const card = cards.find(({ id }) => `#${id}` === decodeURIComponent(location.hash));
    if (!card) return;
    if (card.hidden) {
      form.reset();
      choose();
    }
    card.querySelector("details").open = true;
    card.scrollIntoView();
  }

  form.hidden = false;
  form.addEventListener("change", choose);
  form.addEventListener("submit", (event) => event.preventDefault());
  folds.addEventListener("click", () => {
    const open = folds.getAttribute("aria-pressed") !== "true";
    folds.setAttribute("aria-pressed", open);
    for (const card of cards) card.querySelector("details").open = open;
  });
  addEventListener("hashchange", show);
  choose();
  show();
  addEventListener("load", show); // formulas and figures above may have moved it
});
