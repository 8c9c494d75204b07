/* Films: an animated WebP taken apart, so that it can be paused and stepped in both directions.
 *
 * No browser steps through an animated `<img>`, and ImageDecoder is not everywhere. The container is simple: each of
 * its ANMF chunks, wrapped as a file of its own, is an image with a place; drawn in order they make up the frames.
 */
globalThis.explorablesFilms ??= (() => {
  "use strict";

  const STILL_FPS = 1; // at play, for readers who prefer reduced motion
  const keys = { "data-lm-suppress-shortcuts": "true" }; // JupyterLab takes arrow keys for itself unless told otherwise

  function element(tag, attributes = {}, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    node.append(...children);
    return node;
  }

  function little(value, count) {
    return Array.from({ length: count }, (_, index) => (value >> (8 * index)) & 255);
  }

  /* The images that an animated WebP is made of, each with its place and how it joins what is there. */
  function split(bytes) {
    const text = (at) => String.fromCharCode(...bytes.subarray(at, at + 4));
    const number = (at, count) => bytes.subarray(at, at + count).reduceRight((sum, byte) => sum * 256 + byte, 0);
    const patches = [];
    for (let at = 12; at < bytes.length;) {
      const size = number(at + 4, 4);
      const start = at + 8;
      if (text(at) === "ANMF") {
        const width = 1 + number(start + 6, 3);
        const height = 1 + number(start + 9, 3);
        const data = bytes.subarray(start + 16, start + size);
        const extended = [0x10, 0, 0, 0, ...little(width - 1, 3), ...little(height - 1, 3)]; // may be transparent
        const ascii = (word) => [...word].map((letter) => letter.charCodeAt(0));
        const head = [...ascii("RIFF"), ...little(22 + data.length, 4), ...ascii("WEBPVP8X"), ...little(10, 4), ...extended];
        patches.push({
          x: 2 * number(start, 3),
          y: 2 * number(start + 3, 3),
          width,
          height,
          duration: number(start + 12, 3),
          replaces: (bytes[start + 15] & 2) !== 0,
          vanishes: (bytes[start + 15] & 1) !== 0,
          file: new Blob([new Uint8Array(head), data], { type: "image/webp" }),
        });
      }
      at = start + size + (size % 2);
    }
    return patches;
  }

  /* Draw any frame of a film on a canvas: from the present one if it lies before, else from the start. */
  async function projector(base64, spec, canvas) {
    const patches = split(Uint8Array.from(atob(base64), (character) => character.charCodeAt(0)));
    const images = await Promise.all(patches.map((patch) => createImageBitmap(patch.file)));
    const owner = patches.flatMap((patch, index) => Array(Math.max(1, Math.round(patch.duration / spec.duration))).fill(index));
    const context = canvas.getContext("2d");
    let drawn = -1;
    return (frame) => {
      const wanted = owner[Math.min(frame, owner.length - 1)];
      if (wanted < drawn) drawn = -1;
      if (drawn < 0) context.clearRect(0, 0, canvas.width, canvas.height);
      while (drawn < wanted) {
        const before = patches[drawn];
        if (before?.vanishes) context.clearRect(before.x, before.y, before.width, before.height);
        const patch = patches[++drawn];
        if (patch.replaces) context.clearRect(patch.x, patch.y, patch.width, patch.height);
        context.drawImage(images[drawn], patch.x, patch.y);
      }
    };
  }

  function hydrate(root) {
    root.dataset.ready = "";
    const spec = JSON.parse(root.querySelector(".rp-spec").textContent);
    const states = root.querySelector(".rp-states");
    const canvas = element("canvas", { width: spec.width, height: spec.height, role: "img", "aria-label": spec.alt });
    const last = spec.count - 1;
    let frame = spec.poster;
    let untouched = true;
    let timer = null;
    let ready = null;

    const play = element("button", { type: "button", class: "rp-play", ...keys }, "Play");
    const back = element("button", { type: "button", "aria-label": "One frame back", ...keys }, "◂");
    const on = element("button", { type: "button", "aria-label": "One frame on", ...keys }, "▸");
    const track = element("input", { type: "range", min: 0, max: last, step: 1, "aria-label": "Frame", ...keys });
    const place = element("output", { "aria-live": "off", style: `min-width: ${2 * `${spec.count}`.length + 4}ch` });
    const complaint = element("p", { class: "rp-error", role: "alert", hidden: "" });

    function load() {
      const base64 = () => (states ? JSON.parse(states.textContent) : explorables.fetchStates(root));
      ready ??= Promise.resolve().then(base64).then((text) => projector(text, spec, canvas));
      return ready;
    }

    function show() {
      track.value = frame;
      track.setAttribute("aria-valuetext", `${frame + 1} of ${spec.count}`);
      place.value = `${frame + 1} of ${spec.count}`;
    }

    async function go(target) {
      frame = Math.max(0, Math.min(last, target));
      untouched = false;
      show();
      try {
        (await load())(frame); // the newest wins
        root.dataset.drawn = frame;
      } catch (error) {
        complaint.textContent = error.message;
        complaint.hidden = false;
        stop();
      }
    }

    function stop() {
      clearTimeout(timer);
      timer = null;
      play.textContent = "Play";
    }

    function schedule() {
      const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
      timer = setTimeout(advance, calm ? Math.max(1000 / STILL_FPS, spec.duration) : spec.duration);
    }

    async function advance() {
      if (!root.isConnected) return stop();
      await go(frame + 1);
      if (timer === null) return;
      if (frame >= last) stop();
      else schedule();
    }

    function toggle() {
      if (timer !== null) return stop();
      play.textContent = "Pause";
      if (untouched || frame >= last) go(0);
      schedule();
    }

    function step(target) {
      stop();
      go(target);
    }

    const moves = { ArrowLeft: () => frame - 1, ArrowRight: () => frame + 1, Home: () => 0, End: () => last };
    root.addEventListener("keydown", (event) => {
      if (event.altKey || event.ctrlKey || event.metaKey) return;
      if (event.key === " " && event.target.tagName !== "BUTTON") toggle(); // a button answers by itself
      else if (event.key in moves) step(moves[event.key]());
      else return;
      event.preventDefault();
    });
    play.addEventListener("click", toggle);
    canvas.addEventListener("click", toggle);
    back.addEventListener("click", () => step(frame - 1));
    on.addEventListener("click", () => step(frame + 1));
    track.addEventListener("input", () => step(track.valueAsNumber));
    for (const sign of ["pointerenter", "focusin"]) root.addEventListener(sign, load, { once: true });

    const buttons = element("span", { class: "rp-track" }, back, play, on);
    const row = element("div", { class: "rp-control", role: "group", "aria-label": "Film" }, buttons, track, place);
    const screen = root.querySelector(".rp-canvas");
    screen.append(canvas);
    screen.after(element("div", { class: "rp-controls" }, row, complaint));
    show();
  }

  return { hydrateAll: () => document.querySelectorAll(".rp-film:not([data-ready])").forEach(hydrate) };
})();

if (document.readyState === "loading") {
  document.addEventListener("DOMContentLoaded", explorablesFilms.hydrateAll);
} else {
  explorablesFilms.hydrateAll();
}
