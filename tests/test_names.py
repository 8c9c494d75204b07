"""Names that functions use: ruff cannot look for them, because shapes of arrays are names, too."""

import builtins
import dis
from collections.abc import Iterator
from pathlib import Path
from types import CodeType

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = (
    *("lib/robot_perception", "lib/explorables", "lib/studies"),
    *("data_synth", "tests/tools/benchmarks"),
)


def modules() -> Iterator[str]:
    """Yield the names of the modules whose functions are looked at."""
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            if file.stem != "__main__":
                path = file.relative_to(ROOT).with_suffix("").parts
                yield ".".join(path[path[0] == "lib" :]).removesuffix(".__init__")


def unknown(code: CodeType, known: set[str]) -> Iterator[str]:
    """Yield the global names that some code loads and that are not known."""
    steps = list(dis.get_instructions(code))
    known = known | {step.argval for step in steps if step.opname == "STORE_NAME"}  # by a script
    for step in steps:
        if step.opname == "LOAD_GLOBAL" and step.argval not in known:
            yield step.argval
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from unknown(inner, known)


@pytest.mark.parametrize("name", list(modules()))
def test_every_name_that_a_function_uses_is_known(name: str) -> None:
    module = pytest.importorskip(name)
    source = Path(str(module.__file__))
    code = compile(source.read_bytes(), str(source), "exec")
    assert not set(unknown(code, {*dir(builtins), *vars(module)}))


def test_a_name_that_is_not_known_is_found() -> None:
    code = compile("def run():\n    return [step(x) for x in range(3)]", "none", "exec")
    assert list(unknown(code, {"range"})) == ["step"]
