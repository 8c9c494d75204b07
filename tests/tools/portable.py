"""The tests as other processors run them: other BLAS kernels, and vector units held back.

``python -m tests.tools.portable`` prints a line for each; further words go to pytest. Every
processor gets the unit tests, and the notebooks with their compared outputs; the site in its
browser is the same on every processor and left out. Each has caches of its own, empty at first:
what another processor computed or compiled would hide what this one does.
"""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping

from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

KERNELS = {"Nehalem": "SSE42", "Haswell": "AVX2", "Zen": "AVX2", "SkylakeX": "AVX512_SKX"}
"""OpenBLAS's kernels, and the instructions that a processor must have for each."""

_WIDE = [name for name in __cpu_dispatch__ if "AVX512" in name or name == "X86_V4"]
HELD = {
    "SSE42": {
        "NPY_DISABLE_CPU_FEATURES": " ".join(__cpu_dispatch__),
        "NUMBA_CPU_NAME": "generic",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4",
        "OPENCV_CPU_DISABLE": "AVX512-SKX,AVX2,FP16,AVX",
        "OPENCV_IPP": "sse42",
    },
    "AVX2": {
        "NPY_DISABLE_CPU_FEATURES": " ".join(_WIDE),
        "NUMBA_CPU_NAME": "haswell",
        "NUMBA_CPU_FEATURES": "+avx2,+fma",
        "OPENCV_CPU_DISABLE": "AVX512-SKX",
        "OPENCV_IPP": "avx2",
    },
    "AVX512_SKX": {},
}
"""What holds NumPy, compiled kernels, the library of C, OpenCV, and Intel's library in it to
instructions."""
BASELINE = HELD["SSE42"] | {
    "OPENBLAS_CORETYPE": "Nehalem",
    "OPENCV_CPU_DISABLE": "AVX512-SKX,AVX2,FP16,AVX,SSE4.2,SSE4.1",
    "OPENCV_IPP": "disabled",
}
"""The least that the libraries are built for."""

RUNS = {
    "tests": ["-m", "not slow", "--ignore", "tests/site", "tests"],
    "notebooks": ["--nbval-lax", "book"],
}
ASK = "import numpy, threadpoolctl as t; print(t.threadpool_info()[0].get('architecture'))"


def variants() -> Iterator[tuple[str, dict[str, str]]]:
    """Yield name and environment of what can be tested here; print what cannot."""
    seen: dict[str, str] = {}
    for name, instructions in KERNELS.items():
        environment = {"OPENBLAS_CORETYPE": name} | HELD[instructions]
        if not __cpu_features__.get(instructions):
            print(f"{name:18s}  needs {instructions}, which this processor does not have")
        elif (taken := python("-c", ASK, **environment).stdout.strip()) in seen:
            print(f"{name:18s}  is {seen[taken]} to this OpenBLAS")
        elif taken == name:
            seen[taken] = name
            yield name, environment
        else:
            print(f"{name:18s}  is not in this BLAS, which takes {taken}")
    yield "the baseline", BASELINE


def python(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run Python in an environment."""
    command = [sys.executable, *words]
    return subprocess.run(command, env=os.environ | environment, capture_output=True, text=True)


def passes(name: str, environment: Mapping[str, str], words: list[str]) -> bool:
    """Run tests in an environment, print the line of it, and what failed."""
    failures = []
    print(f"{name:18s}", end="", flush=True)
    with tempfile.TemporaryDirectory() as cache:
        own = {**environment, "ROBOT_PERCEPTION_CACHE": cache, "NUMBA_CACHE_DIR": cache}
        for what, chosen in RUNS.items():
            run = python("-m", "pytest", "-q", *words, *chosen, **own)
            (*_, last) = run.stdout.splitlines() or [""]
            print(
                f"  {what}: {re.sub(r', [0-9]+ deselected|[(=].*', '', last).strip()}",
                end="",
                flush=True,
            )
            failures += [run.stdout + run.stderr] if run.returncode else []
    print(*failures, sep="\n")
    return not failures


if __name__ == "__main__":
    results = [passes(*variant, sys.argv[1:]) for variant in variants()]
    sys.exit(not all(results))
