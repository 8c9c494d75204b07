"""A real JupyterLab on loopback with fresh settings, for copies of notebooks."""

import json
import os
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Page

DATA = "ROBOT_PERCEPTION_DATA"
LAB_PAGES = "ROBOT_PERCEPTION_LAB_PAGES"
"""Notebooks that the tests run in JupyterLab: names with commas between them, or ``all``."""
SETTINGS = {
    "notebook-extension/tracker": {"windowingMode": "none"},  # every cell in the page, seen or not
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
}
IDLE = ".jp-Notebook-ExecutionIndicator[data-status=idle]"
OPEN = """
async (path) => {
  await jupyterapp.restored;
  const widget = await jupyterapp.commands.execute("docmanager:open", { path });
  await widget.context.ready;
  await widget.sessionContext.ready;
  while (jupyterapp.shell.currentWidget !== widget) {
    jupyterapp.shell.activateById(widget.id);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}
"""
FAILED = """
() => {
  const kind = "data-mime-type='application/vnd.jupyter";
  const outputs = document.querySelectorAll(`[${kind}.error'], [${kind}.stderr']`);
  const texts = [...outputs].map((output) => output.innerText);
  return texts.filter((text) => /Traceback|^ *\\w*Error:/m.test(text)).join("\\n\\n");
}
"""
CELL = """
(text) => {
  const { content } = jupyterapp.shell.currentWidget;
  const found = content.widgets.map((cell) => cell.model.sharedModel.getSource().includes(text));
  if (found.filter(Boolean).length !== 1) throw new Error(`not one cell has ${text}`);
  return found.indexOf(true);
}
"""
OUTPUTS = """
(number) => {
  const { outputs } = jupyterapp.shell.currentWidget.content.widgets[number].model;
  return outputs.toJSON().map((output) => output.data);  // counts of execution always differ
}
"""
EDIT = """
([number, old, replacement]) => {
  const { content } = jupyterapp.shell.currentWidget;
  const { sharedModel } = content.widgets[number].model;
  sharedModel.setSource(sharedModel.getSource().replace(old, () => replacement));
  content.activeCellIndex = number;
}
"""
START_S = 120
RUN_S = 600


@dataclass(frozen=True)
class Lab:
    """A JupyterLab that runs.

    Parameters
    ----------
    address
        Where it is served.
    folder
        What it serves.
    token
        What it wants to be told.
    """

    address: str
    folder: Path
    token: str

    def ask(self, path: str, method: str = "GET") -> bytes:
        """Return the answer of the server's interface."""
        headers = {"Authorization": f"token {self.token}"}
        request = urllib.request.Request(f"{self.address}/{path}", method=method, headers=headers)
        with urllib.request.urlopen(request, timeout=30) as answer:
            return answer.read()

    def end_kernels(self) -> None:
        """End every kernel."""
        for session in json.loads(self.ask("api/sessions")):
            self.ask(f"api/sessions/{session['id']}", "DELETE")

    def open(self, page: Page, notebook: str) -> None:
        """Open a notebook in an empty workspace and wait for its kernel."""
        page.goto(f"{self.address}/lab?reset&token={self.token}")
        page.wait_for_function("() => globalThis.jupyterapp", timeout=START_S * 1000)
        page.evaluate(OPEN, notebook)

    def command(self, page: Page, name: str) -> None:
        """Execute a command of JupyterLab, as its menus do, and wait until it is done."""
        page.evaluate("(name) => jupyterapp.commands.execute(name)", name)

    def run_all(self, page: Page, notebook: str) -> None:
        """Run all cells of the open notebook and wait until the kernel is idle.

        Raises
        ------
        RuntimeError
            If a cell fails; the message holds what the notebook shows.
        """
        self._run(page, notebook, "notebook:run-all-cells")

    def edit(self, page: Page, notebook: str, old: str, new: str) -> None:
        """Type a text in place of another, which one cell has; run this cell and all below.

        Raises
        ------
        RuntimeError
            If a cell fails; the message holds what the notebook shows.
        """
        page.evaluate(EDIT, [page.evaluate(CELL, old), old, new])
        self._run(page, notebook, "notebook:run-all-below")

    def outputs(self, page: Page, text: str) -> str:
        """Return what the one cell with a text shows, as JSON."""
        return json.dumps(page.evaluate(OUTPUTS, page.evaluate(CELL, text)), sort_keys=True)

    def _run(self, page: Page, notebook: str, command: str) -> None:
        self.command(page, command)
        page.wait_for_selector(IDLE, timeout=RUN_S * 1000)
        if failed := page.evaluate(FAILED):
            raise RuntimeError(f"{notebook} fails in JupyterLab:\n{failed}")


@contextmanager
def jupyterlab(notebooks: Iterable[Path]) -> Iterator[Lab]:
    """Serve copies of notebooks by JupyterLab with fresh settings."""
    with tempfile.TemporaryDirectory() as folder, socket.socket() as probe:
        root = Path(folder)
        work = root / "work"
        work.mkdir()
        for notebook in notebooks:
            shutil.copy(notebook, work)
        for name, values in SETTINGS.items():
            file = root / "settings" / "@jupyterlab" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.with_suffix(".jupyterlab-settings").write_text(json.dumps(values))
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
        probe.close()
        token = secrets.token_hex(16)
        environment = os.environ | {
            "IPYTHONDIR": str(root / "ipython"),
            "JUPYTER_CONFIG_DIR": str(root / "config"),
            "JUPYTER_DATA_DIR": str(root / "data"),
            "JUPYTER_RUNTIME_DIR": str(root / "runtime"),
            "JUPYTERLAB_SETTINGS_DIR": str(root / "settings"),
            "JUPYTERLAB_WORKSPACES_DIR": str(root / "workspaces"),
            "JUPYTER_TOKEN": token,
        }
        if os.environ.get(DATA):  # the notebooks run in another folder
            environment[DATA] = str(Path(os.environ[DATA]).resolve())
        options = ("--no-browser", "--allow-root", "--expose-app-in-browser")
        where = (f"--ServerApp.port={port}", "--ServerApp.ip=127.0.0.1")
        server = subprocess.Popen(
            [sys.executable, "-m", "jupyter", "lab", *options, *where],
            cwd=work,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            yield _when_up(Lab(f"http://127.0.0.1:{port}", work, token), server)
        finally:
            server.terminate()
            try:
                server.wait(60)
            except subprocess.TimeoutExpired:  # it waits for a kernel that does not end
                server.kill()
                server.wait()


def _when_up(lab: Lab, server: subprocess.Popen[bytes]) -> Lab:
    for _ in range(2 * START_S):
        if server.poll() is not None:
            raise RuntimeError(f"JupyterLab ended with code {server.returncode}")
        try:
            lab.ask("api/status")
            return lab
        except OSError:
            time.sleep(0.5)
    raise RuntimeError("JupyterLab did not start within two minutes")
