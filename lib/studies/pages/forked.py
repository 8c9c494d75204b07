"""Kernels that start at once: forked off a process that has imported what most pages import.

Every page of the book imports the same packages, which takes longer than some pages compute. Here
one process imports them, and a kernel is a fork of it. Where processes cannot be forked safely, and
where that process has died, kernels start as they always do.
"""

import json
import os
import runpy
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.metadata import EntryPoint
from threading import Lock
from typing import Any

from jupyter_client.provisioning import KernelProvisionerFactory, LocalProvisioner

CAN_FORK = sys.platform == "linux"  # elsewhere system libraries do not survive it
NAME = "studies-forked"
IMPORTED = (
    "cv2",
    "IPython",
    "ipykernel.kernelapp",
    "ipywidgets",
    "anywidget",
    "matplotlib.figure",
    "numba",
    "pandas",
    "scipy.ndimage",
    "scipy.spatial.transform",
    "scipy.stats",
)
"""Packages of others; none of them starts a thread, or reads a page's variables, when imported."""


class Kernel:
    """A forked kernel, with what Jupyter's client asks of a `subprocess.Popen`."""

    stdin = stdout = stderr = None

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self.returncode: int | None = None

    def poll(self) -> int | None:
        """Return ``None`` while it runs; how it ended is known to its parent only."""
        if not self._is_sent(0):
            self.returncode = 0
        return self.returncode

    wait = poll  # the client waits until it has ended

    def send_signal(self, number: int) -> None:
        """Send it a signal."""
        self._is_sent(number)

    def terminate(self) -> None:
        """Ask it to end."""
        self._is_sent(signal.SIGTERM)

    def kill(self) -> None:
        """End it."""
        self._is_sent(signal.SIGKILL)

    def _is_sent(self, number: int) -> bool:
        try:
            os.kill(self.pid, number)
        except ProcessLookupError:
            return False
        return True


class Forked(LocalProvisioner):
    """Gives Jupyter's client forked kernels."""

    server: subprocess.Popen | None = None
    asking = Lock()

    async def launch_kernel(self, cmd: list[str], **kwargs: Any) -> Any:
        """Have a kernel forked."""
        place = str(kwargs.get("cwd") or os.getcwd())
        order = json.dumps({"argv": cmd, "env": kwargs["env"], "cwd": place})
        with Forked.asking, suppress(OSError):
            Forked.server.stdin.write(f"{order}\n")
            Forked.server.stdin.flush()
            if answer := Forked.server.stdout.readline():
                self.process = Kernel(int(answer))
        if self.process is None:
            return await super().launch_kernel(cmd, **kwargs)
        self.pid = self.pgid = self.process.pid  # it begins a session
        self.cwd = place
        return self.connection_info


@contextmanager
def forked_kernels() -> Iterator[None]:
    """Have kernels that are started meanwhile forked, where that is safe."""
    if not CAN_FORK:
        yield
        return
    factory = KernelProvisionerFactory.instance()
    before = factory.default_provisioner_name
    command = [sys.executable, "-P", "-c", f"from {__name__} import serve; serve()"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as Forked.server:
        factory.provisioners[NAME] = EntryPoint(NAME, f"{__name__}:Forked", factory.GROUP_NAME)
        factory.default_provisioner_name = NAME
        try:
            yield
        finally:
            factory.default_provisioner_name = before
            with suppress(BrokenPipeError):
                Forked.server.stdin.close()  # no more orders: it ends


def serve() -> None:
    """Fork a kernel for each order that comes in, a line of JSON, and answer its process."""
    os.environ["JPY_PARENT_PID"] = str(os.getpid())  # read by ipykernel when it is imported
    for name in IMPORTED:
        with suppress(ImportError):
            import_module(name)
    _warm_up()
    signal.signal(signal.SIGCHLD, _take_leave)
    for order in iter(sys.stdin.readline, ""):
        pid = os.fork()
        if pid == 0:
            _be_kernel(**json.loads(order))
        print(pid, flush=True)


def _take_leave(*_: object) -> None:
    """Let kernels that have ended go, their time counted as that of this process's children."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _warm_up() -> None:
    """Have numba compile what it compiles first in every process, whatever the kernels are.

    A third of a second for itself, and two to put into words that a slice does not fit.
    """
    import numba
    import numpy as np

    @numba.njit
    def put(rows: np.ndarray, row: np.ndarray) -> None:
        rows[0, :] = row

    put(np.zeros((1, 2)), np.ones(2))


def _be_kernel(argv: list[str], env: dict[str, str], cwd: str) -> None:
    """Run in this process what ``python -m module …`` would run in one of its own."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setsid()
    with open(os.devnull) as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)  # the other end of 1 waits for answers
    os.environ.clear()
    os.environ.update(env, JPY_PARENT_PID=str(os.getppid()))
    os.chdir(cwd)
    # IPython looks into the page's folder before packages, but not where a safe path is asked for
    packages = (
        k for k, path in enumerate(sys.path) if path.endswith(("site-packages", "dist-packages"))
    )
    sys.path.insert(next(packages, len(sys.path)), "")
    module, *sys.argv[1:] = argv[argv.index("-m") + 1 :]
    runpy.run_module(module, run_name="__main__", alter_sys=True)
    sys.exit()
