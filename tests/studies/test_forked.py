"""Forked kernels are kernels like others that have packages before they ask for them."""

import asyncio
import json
import os
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, DeadKernelError

from studies.pages import forked
from studies.pages.forked import Forked, Kernel, forked_kernels

pytestmark = pytest.mark.skipif(not forked.CAN_FORK, reason="kernels are forked on Linux only")

ASKED = """
import json, os, signal, sys
here = {"there": "scipy.stats" in sys.modules, "place": os.getcwd(), "name": __name__,
        "colour": os.environ.get("COLOUR"), "path": sys.path, "command": sys.argv[1:2],
        "children": signal.getsignal(signal.SIGCHLD) == signal.SIG_DFL}
print(json.dumps(here))
print(os.getpid(), os.getppid())
"""


def printed(code: str, place: Path) -> list[str]:
    """Run code in a kernel, in some folder; return the lines that it prints."""
    cell = nbformat.v4.new_code_cell(code)
    notebook = nbformat.v4.new_notebook(cells=[cell])
    NotebookClient(notebook, resources={"metadata": {"path": str(place)}}).execute()
    return cell.outputs[0].text.splitlines()


def is_gone(pid: int) -> bool:
    """Tell whether a process ends within half a minute."""
    end = time.monotonic() + 30
    while Kernel(pid).poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    return Kernel(pid).poll() is not None


def test_a_forked_kernel_is_as_another_with_packages_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("COLOUR", "red")
    found = []
    for kernels in (forked_kernels, nullcontext):
        with kernels():
            monkeypatch.setenv("COLOUR", "green")  # after the process that forks has started
            asked, numbers = printed(ASKED, tmp_path)
            found.append((json.loads(asked), *map(int, numbers.split())))
    (ours, pid, parent), (theirs, _, other) = found
    assert (ours.pop("there"), theirs.pop("there")) == (True, False)
    assert ours == theirs
    assert (ours["place"], ours["colour"]) == (str(tmp_path), "green")
    assert (parent, other) == (Forked.server.pid, os.getpid())
    assert is_gone(pid)


def test_the_time_of_forked_kernels_is_counted(tmp_path: Path):
    work = "import os, time\nwhile time.process_time() < 3: pass\nprint(os.getpid())"
    with forked_kernels():
        (pid,) = printed(work, tmp_path)
        assert is_gone(int(pid))
        about = Path(f"/proc/{Forked.server.pid}/stat").read_text().rpartition(")")[2].split()
        assert sum(map(int, about[13:15])) / os.sysconf("SC_CLK_TCK") > 2.5  # of its children, s


def test_what_goes_wrong_in_a_forked_kernel_is_told(tmp_path: Path):
    with forked_kernels():
        with pytest.raises(CellExecutionError, match="ZeroDivisionError"):
            printed("1 / 0", tmp_path)
        with pytest.raises(DeadKernelError):
            printed("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", tmp_path)
        assert printed("print(1)", tmp_path) == ["1"]


def test_kernels_start_where_nothing_forks_them(tmp_path: Path):
    with forked_kernels():
        Forked.server.kill()
        Forked.server.wait()
        assert printed("import os; print(os.getppid())", tmp_path) == [str(os.getpid())]


def test_a_kernel_ends_with_the_process_that_forked_it(tmp_path: Path):
    code = "import os, time; open('pid', 'w').write(str(os.getpid())); time.sleep(60)"
    kernel = tmp_path / "pid"

    async def started() -> None:
        notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(code)])
        client = NotebookClient(notebook, resources={"metadata": {"path": str(tmp_path)}})
        running = asyncio.ensure_future(client.async_execute())
        while not kernel.exists() or not kernel.read_text():
            await asyncio.sleep(0.05)
        Forked.server.kill()
        with pytest.raises(DeadKernelError):
            await running

    with forked_kernels(), ThreadPoolExecutor(1) as pool:  # a browser's loop may run in this thread
        pool.submit(asyncio.run, started()).result()
    assert is_gone(int(kernel.read_text()))
