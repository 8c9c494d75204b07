/* Opened from a folder, a browser shows a page's source where it should save it: then it comes as a script. */
(() => {
  "use strict";
  globalThis.robotPerceptionSave = (name, text) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/octet-stream" }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  };

  if (location.protocol !== "file:") return;
  addEventListener("click", (event) => {
    const button = event.target.closest?.("a.btn-download-source-button");
    if (!button) return;
    event.preventDefault();
    const script = document.createElement("script");
    script.src = `${button.href}.js`;
    script.onload = () => script.remove();
    document.head.append(script);
  });
})();
