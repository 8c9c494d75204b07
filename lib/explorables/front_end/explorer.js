/* Explorers: one front end for Jupyter (as an anywidget module) and for built pages (as a classic script).
 *
 * A source answers `source(indices, tell)` with a promise of { html } or { src, alt }: in Jupyter it asks the kernel and
 * tells the reader why a picture is late, on a page it looks the state up. One request is in flight at any time; when it
 * returns, only the newest is sent. A source that gives up answers null; what still comes is followed.
 */
globalThis.explorables ??= (() => {
  "use strict";

  const SILENCE_MS = 700; // before a move is announced to a screen reader
  const PATIENCE_MS = 1000; // before the reader is told that the kernel is busy
  const ABSENCE_MS = 3000; // of a kernel that is not busy and does not answer: it does not know this explorer
  const STILL_FPS = 1; // at play, for readers who prefer reduced motion
  let serial = 0;

  function element(tag, attributes = {}, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (value !== undefined && value !== false) node.setAttribute(name, value === true ? "" : value);
    }
    node.append(...children);
    return node;
  }

  // JupyterLab takes arrow keys and letters for itself unless an input says otherwise.
  const keys = { "data-lm-suppress-shortcuts": "true" };

  function button(text, attributes = {}) {
    return element("button", { type: "button", ...keys, ...attributes }, text);
  }

  function sliderControl(control, id, moved) {
    const input = element("input", {
      type: "range", id, min: 0, max: control.shown.length - 1, step: 1, ...keys,
    });
    const widest = Math.max(...control.shown.map((text) => text.length)); // the value changes, its room does not
    const output = element("output", { for: id, "aria-live": "off", style: `min-width: ${widest}ch` });
    input.addEventListener("input", () => moved(input.valueAsNumber));
    return {
      nodes: [element("label", { for: id }, control.label), input, output],
      set(index) {
        input.value = index;
        input.setAttribute("aria-valuetext", control.shown[index]);
        output.value = control.shown[index];
      },
      input,
    };
  }

  function timelineControl(control, id, moved) {
    const range = sliderControl(control, id, (index) => { stop(); moved(index); });
    const last = control.shown.length - 1;
    const play = button("Play", { class: "rp-play", "aria-label": `Play: ${control.label}` });
    let timer = null;
    function stop() {
      if (timer === null) return;
      clearTimeout(timer);
      timer = null;
      play.textContent = "Play";
      play.setAttribute("aria-label", `Play: ${control.label}`);
    }
    function step() {
      if (!range.input.isConnected) return stop();
      const index = range.input.valueAsNumber + 1;
      Promise.resolve(moved(index, true)).then(() => {
        if (timer === null) return;
        if (index >= last) return stop();
        schedule();
      });
    }
    function schedule() {
      const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
      timer = setTimeout(step, 1000 / (calm ? Math.min(STILL_FPS, control.fps) : control.fps));
    }
    play.addEventListener("click", () => {
      if (timer !== null) return stop();
      if (range.input.valueAsNumber >= last) moved(0);
      play.textContent = "Pause";
      play.setAttribute("aria-label", `Pause: ${control.label}`);
      schedule();
    });
    const [label, input, output] = range.nodes;
    return { nodes: [label, element("span", { class: "rp-track" }, play, input), output], set: range.set, stop };
  }

  function selectControl(control, id, moved) {
    const select = element("select", { id, ...keys }, ...control.shown.map((text) => element("option", {}, text)));
    select.addEventListener("change", () => moved(select.selectedIndex));
    return {
      nodes: [element("label", { for: id }, control.label), select],
      set(index) { select.selectedIndex = index; },
    };
  }

  function radioControl(control, id, moved) {
    const inputs = control.shown.map((text, index) => {
      const input = element("input", { type: "radio", name: id, id: `${id}-${index}`, ...keys });
      input.addEventListener("change", () => moved(index));
      return input;
    });
    const pills = inputs.map((input, index) =>
      element("span", { class: "rp-pill" }, input, element("label", { for: input.id }, control.shown[index])));
    const name = element("span", { class: "rp-name", id: `${id}-name` }, control.label);
    const group = element("span", { class: "rp-pills", role: "radiogroup", "aria-labelledby": `${id}-name` }, ...pills);
    return {
      nodes: [name, group],
      set(index) { inputs[index].checked = true; },
    };
  }

  function toggleControl(control, id, moved) {
    const input = element("input", { type: "checkbox", id, ...keys });
    input.addEventListener("change", () => moved(input.checked ? 1 : 0));
    return {
      nodes: [element("span", { class: "rp-tick" }, input, element("label", { for: id }, control.label))],
      set(index) { input.checked = index === 1; },
    };
  }

  function makeControl(control, id, moved) {
    if (control.kind === "slider") return sliderControl(control, id, moved);
    if (control.kind === "timeline") return timelineControl(control, id, moved);
    if (control.kind === "toggle") return toggleControl(control, id, moved);
    const short = control.shown.length <= 4 && control.shown.join("").length <= 48;
    return (short ? radioControl : selectControl)(control, id, moved);
  }

  function paint(canvas, frame) {
    if (frame.html !== undefined) {
      canvas.innerHTML = frame.html;
      return;
    }
    const old = canvas.querySelector("img.rp-frame");
    const image = old ?? element("img", { class: "rp-frame dark-light" });
    image.alt = frame.alt;
    image.src = frame.src;
    if (frame.width) {
      image.width = frame.width;
      image.height = frame.height;
    }
    if (!old) canvas.replaceChildren(image);
  }

  /* A grip on the point that one or two controls move. The drawing holds the point's place for each of their states, the
   * last control fastest; the grip goes to the nearest one under a pointer, or to the neighbour in an arrow's direction. */
  function makeGrip(spec, canvas, moved, held) {
    const { controls: names, label } = spec.drag;
    const sizes = names.map((name) => spec.controls.find((control) => control.name === name).shown.length);
    const grip = button("", {
      class: "rp-grip", "aria-label": `Move ${label}: drag it, or use the arrow keys`, title: "Drag me", hidden: true,
    });
    let here = {};

    function states() { // where each state of the controls would put the point, in pixels of the window
      const note = canvas.querySelector("metadata.rp-places");
      const matrix = note?.closest("svg").getScreenCTM();
      if (!matrix) return [];
      return note.textContent.split(" ").flatMap((word, place) => {
        if (word === "-") return [];
        const at = new DOMPoint(...word.split(",").map(Number)).matrixTransform(matrix);
        const last = sizes.at(-1);
        const indices = names.length === 1 ? [place] : [Math.floor(place / last), place % last];
        return [{ x: at.x, y: at.y, indices }];
      });
    }
    const same = (state) => names.every((name, which) => here[name] === state.indices[which]);
    const go = (state) => moved(Object.fromEntries(names.map((name, which) => [name, state.indices[which]])));

    function put() {
      const state = states().find(same);
      grip.hidden = !state;
      if (!state) return;
      const frame = grip.offsetParent?.getBoundingClientRect();
      if (!frame) return;
      grip.style.left = `${state.x - frame.left}px`;
      grip.style.top = `${state.y - frame.top}px`;
    }

    function nearest({ clientX, clientY }) {
      const away = (state) => Math.hypot(state.x - clientX, state.y - clientY);
      return states().reduce((best, state) => (best && away(best) <= away(state) ? best : state), null);
    }
    grip.addEventListener("pointerdown", (event) => {
      grip.setPointerCapture(event.pointerId);
      event.preventDefault(); // no selection of text, no scrolling
      grip.focus();
      held();
    });
    grip.addEventListener("pointermove", (event) => {
      const state = grip.hasPointerCapture(event.pointerId) && nearest(event);
      if (state && !same(state)) go(state);
    });

    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    grip.addEventListener("keydown", (event) => {
      const [right, down] = arrows[event.key] ?? [0, 0];
      if (!right && !down) return;
      event.preventDefault();
      const all = states();
      const now = all.find(same);
      const along = (state) => (state.x - now.x) * right + (state.y - now.y) * down;
      const steps = (state) => state.indices.reduce((sum, index, which) => sum + Math.abs(index - here[names[which]]), 0);
      const best = now && all.filter((state) => steps(state) === 1 && along(state) > 0.5)
        .sort((a, b) => along(b) - along(a))[0];
      if (best) {
        held();
        go(best);
      }
    });

    new ResizeObserver(put).observe(canvas);
    return { grip, put, set(indices) { here = indices; put(); } };
  }

  /* Put controls under a canvas that shows the default state. Returns { go, follow }: go to a setting; follow a picture
   * that was not asked for, or comes after the source has given up. */
  function mount(root, spec, canvas, before, source) {
    const id = `rp-${++serial}`;
    const defaults = Object.fromEntries(spec.controls.map((control) => [control.name, control.default]));
    let indices = defaults;
    let wanted = false;
    let running = null;
    let announcement = null;

    const status = element("p", { class: "rp-status", role: "status" });
    const complaint = element("p", { class: "rp-error", role: "alert", hidden: true });
    const notice = element("p", { class: "rp-notice", role: "status", hidden: true });

    function say(place, text) {
      place.textContent = text;
      place.hidden = !text;
    }

    function take(answer) { // a picture, an error, or null if there is none yet
      if (!answer) return;
      const failed = answer instanceof Error;
      if (!failed) {
        paint(canvas, answer);
        grip?.put();
      }
      say(complaint, failed ? answer.message : "");
      say(notice, "");
    }

    function announce() {
      clearTimeout(announcement);
      announcement = setTimeout(() => {
        const setting = spec.controls.map((c) => `${c.label}: ${c.shown[indices[c.name]]}`).join("; ");
        const picture = canvas.firstElementChild; // a drawing, a row of them, or an image
        const alt = picture?.getAttribute("aria-label") ?? picture?.getAttribute("alt") ?? "";
        status.textContent = spec.spoken ? `${setting}. ${alt}` : `${setting}.`;
      }, SILENCE_MS);
    }

    async function run() {
      root.toggleAttribute("data-busy", true);
      while (wanted) {
        wanted = false;
        take(await source({ ...indices }, (text) => say(notice, text)).catch((error) => error));
      }
      root.toggleAttribute("data-busy", false);
      running = null;
      announce();
    }

    function ask() {
      wanted = true;
      running ??= run();
      return running;
    }

    function set(change) {
      indices = { ...indices, ...change };
      for (const [name, control] of Object.entries(controls)) control.set(indices[name]);
      grip?.set(indices);
      for (const [preset, node] of presets) {
        const here = Object.entries(preset.indices).every(([name, index]) => indices[name] === index);
        node.setAttribute("aria-pressed", here);
      }
    }

    function go(change) {
      set(change);
      return ask();
    }

    function jump(target) {
      halt();
      return go(target);
    }

    const halt = () => Object.values(controls).forEach((control) => control.stop?.());
    const grip = spec.drag && makeGrip(spec, canvas, go, halt);
    const controls = Object.fromEntries(spec.controls.map((control) => {
      const moved = (index) => go({ [control.name]: index });
      return [control.name, makeControl(control, `${id}-${control.name}`, moved)];
    }));
    const presets = spec.presets.map((preset) => {
      const node = button(preset.label, { class: "rp-preset" });
      node.addEventListener("click", () => jump(preset.indices));
      return [preset, node];
    });
    const reset = button("Reset", { class: "rp-reset" });
    reset.addEventListener("click", () => jump(defaults));

    const rows = spec.controls.map((control) =>
      element("div", { class: `rp-control rp-${control.kind}` }, ...controls[control.name].nodes));
    const buttons = element("div", { class: "rp-buttons" });
    if (presets.length) {
      buttons.append(element("span", { class: "rp-name", id: `${id}-try` }, "Try"));
      buttons.append(element(
        "span", { class: "rp-presets", role: "group", "aria-labelledby": `${id}-try` }, ...presets.map(([, node]) => node)));
    }
    buttons.append(reset);
    const box = element("div", { class: "rp-controls" }, ...rows, buttons, complaint, notice, status);
    before(box);
    if (grip) canvas.after(grip.grip);
    new ResizeObserver(() => { // the picture leaves room for them in the window
      root.style.setProperty("--rp-below", `${Math.ceil(box.getBoundingClientRect().height)}px`);
    }).observe(box);
    set({});

    return {
      go,
      follow(change, answer) {
        set(change);
        take(answer);
        announce();
      },
    };
  }

  /* ---- a built page: states stored beside it ---- */

  const loads = new Map(); // explorer's id -> function that takes its states

  function register(id, states) {
    loads.get(id)?.(states);
  }

  function fetchStates(root) {
    const inside = root.querySelector(".rp-states");
    if (inside) return Promise.resolve(JSON.parse(inside.textContent));
    return new Promise((resolve, reject) => {
      loads.set(root.id, resolve);
      const script = element("script", { src: root.dataset.states });
      script.addEventListener("error", () => reject(new Error("The states of this explorer are missing.")));
      document.head.append(script);
    });
  }

  async function unpack(states) {
    if (typeof states !== "string") {
      return states.map(([src, alt, width, height]) =>
        ({ src: src.endsWith(".webp") ? src : `data:image/webp;base64,${src}`, alt, width, height }));
    }
    const bytes = Uint8Array.from(atob(states), (character) => character.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const { lines, states: rows } = await new Response(stream).json();
    return rows.map((row) => ({ get html() { return row.map((line) => lines[line]).join("\n"); } }));
  }

  function hydrate(root) {
    const spec = JSON.parse(root.querySelector(".rp-spec").textContent);
    const figure = root.querySelector("figure");
    const canvas = root.querySelector(".rp-canvas");
    let frames = null;
    const load = () => (frames ??= fetchStates(root).then(unpack));
    const place = (indices) =>
      spec.controls.reduce((sum, control) => sum * control.shown.length + indices[control.name], 0);
    const base = root.dataset.states?.replace(/[^/]*$/, "");
    async function source(indices) {
      const frame = (await load())[place(indices)];
      if (!frame.src || frame.src.startsWith("data:")) return frame;
      const image = new Image();
      image.src = base + frame.src;
      await image.decode();
      return { ...frame, src: image.src };
    }
    mount(root, spec, canvas, (controls) => canvas.after(controls), source);
    root.addEventListener("pointerenter", load, { once: true });
    root.addEventListener("focusin", load, { once: true });
    const original = canvas.innerHTML;
    let present = null;
    matchMedia("print").addEventListener("change", ({ matches: printing }) => { // paper shows the default
      if (printing) present = canvas.innerHTML;
      canvas.innerHTML = printing ? original : present;
    });
    figure.dataset.ready = "true";
  }

  function hydrateAll() {
    document.querySelectorAll("div.explorer:has(> .rp-spec)").forEach(hydrate);
  }

  /* ---- Jupyter: a kernel behind the widget ---- */

  // A widget is not typeset by Jupyter, and MathJax is out of its reach: simple formulas become plain letters.
  const letters = {
    alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", varepsilon: "ε", eta: "η", theta: "θ", kappa: "κ",
    lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", pi: "π", rho: "ρ", sigma: "σ", tau: "τ", phi: "φ", varphi: "φ", chi: "χ",
    psi: "ψ", omega: "ω", Delta: "Δ", Lambda: "Λ", Sigma: "Σ", Phi: "Φ", Psi: "Ψ", Omega: "Ω", pm: "±", times: "×",
    cdot: "·", le: "≤", leq: "≤", ge: "≥", geq: "≥", approx: "≈", neq: "≠", to: "→", infty: "∞", sum: "∑", top: "⊤",
    ldots: "…", dots: "…", sqrt: "√", circ: "°", prime: "′", in: "∈",
  };

  function readable(tex) {
    return tex
      .replace(/\\(?:mathrm|mathbf|mathit|text|operatorname|left|right|[,;!: ])/g, "")
      .replace(/\\(?:hat|tilde|bar) *\{?(\w)\}?/g, (_, letter) => `${letter}\u0302`)
      .replace(/\\frac *\{([^{}]*)\}\{([^{}]*)\}/g, "$1/$2")
      .replace(/\\([A-Za-z]+)/g, (_, name) => letters[name] ?? name)
      .replace(/\^(?:\{([^{}]*)\}|(\S))/g, (_, group, one) => `<sup>${group ?? one}</sup>`)
      .replace(/_(?:\{([^{}]*)\}|(\S))/g, (_, group, one) => `<sub>${group ?? one}</sub>`)
      .replace(/[{}]/g, "")
      .replace(/-/g, "−");
  }

  const BUSY = "The kernel is busy; the picture follows.";
  const ABSENT = "No kernel answers. Run this cell to bring the explorer to life.";
  const SILENT = "No answer yet. If the kernel is busy, the picture follows; if not, run this cell.";

  function render({ model, el }) {
    const spec = model.get("spec");
    const canvas = element("div", { class: "rp-canvas" });
    const figure = element("figure", { class: spec.figure, id: spec.name || undefined }, canvas);
    const root = element("div", { class: "explorer" }, figure);
    const text = new TextDecoder();
    let request = Date.now() * 1000 + Math.floor(Math.random() * 1000);
    let pending = null; // the request in flight: { number, settle }
    let url = null;

    function decode({ mime, alt }, data) {
      if (mime === "image/svg+xml") return { html: text.decode(data) };
      if (url) URL.revokeObjectURL(url);
      url = URL.createObjectURL(new Blob([data], { type: mime }));
      return { src: url, alt };
    }

    function source(indices, tell) {
      const number = ++request;
      return new Promise((resolve) => {
        function settle(answer) {
          clearInterval(watch);
          pending = null;
          resolve(answer);
        }
        function giveUp(reason) {
          tell(reason);
          settle(null);
        }
        let silence = 0;
        const watch = setInterval(() => {
          const kernel = model.widget_manager?.kernel; // undefined if the front end does not say
          if (kernel?.status === "busy") {
            silence = 0;
            tell(BUSY);
          } else if ((silence += PATIENCE_MS) >= ABSENCE_MS) giveUp(kernel === undefined ? SILENT : ABSENT);
        }, PATIENCE_MS);
        pending = { number, settle };
        try {
          model.send({ type: "draw", request: number, indices });
        } catch { // the comm is closed: another kernel, or none
          giveUp(ABSENT);
        }
      });
    }

    function receive(message, [data]) {
      if (pending && pending.number !== message.request) return; // the answer to the reader's own move follows
      const answer = message.type === "error" ? new Error(message.text) : decode(message, data);
      if (pending) pending.settle(answer);
      else handle.follow(message.indices, answer);
    }

    const picture = model.get("picture");
    paint(canvas, decode(picture, picture.data));
    const handle = mount(root, spec, canvas, (controls) => figure.append(controls), source);
    figure.insertAdjacentHTML(
      "beforeend", spec.caption.replace(/\\\((.*?)\\\)/g, (_, tex) => `<i>${readable(tex)}</i>`));
    model.on("msg:custom", receive);
    el.append(root);
    const observer = new ResizeObserver(() => { // the view is in the document: it replaces the still picture
      const outputs = root.closest(".jp-OutputArea") ?? document;
      const still = outputs.querySelector(`#${model.get("still")}`);
      still?.setAttribute("hidden", "");
      still?.querySelector("figure").removeAttribute("id"); // links lead to the view
    });
    observer.observe(root);
    const indices = model.get("indices"); // another view, or Python, may have moved it
    if (spec.controls.some((control) => indices[control.name] !== control.default)) handle.go(indices);
    return () => {
      model.off("msg:custom", receive);
      observer.disconnect();
      pending?.settle(null);
      if (url) URL.revokeObjectURL(url);
    };
  }

  return { register, fetchStates, render, hydrateAll };
})();

if (globalThis.document?.currentScript) {
  document.addEventListener("DOMContentLoaded", explorables.hydrateAll);
}
