"""A sweep gives the same numbers however many workers there are, in the order of its items."""

import numpy as np
import pytest
from joblib import parallel_config

from studies.sweep import WORKERS, sweep


def draw(item, *, rng):
    return item, float(rng.standard_normal())


def alone(items):
    return sweep(draw, items, rng=np.random.default_rng(7))


def test_each_item_gets_the_generator_of_its_place():
    own = np.random.default_rng(7).spawn(4)
    assert alone("abcd") == [
        (x, float(r.standard_normal())) for x, r in zip("abcd", own, strict=True)
    ]
    assert alone("ab") == alone("abcd")[:2]


@pytest.mark.parametrize("workers", [2, 3])
def test_processes_give_the_same_numbers_in_order(workers):
    with parallel_config(n_jobs=workers):
        assert alone(range(20)) == [*map(tuple, alone_in_one(20))]


def alone_in_one(count):
    with parallel_config(n_jobs=1):
        return alone(range(count))


def test_threads_too():
    with parallel_config(backend="threading", n_jobs=2):
        assert alone(range(9)) == alone_in_one(9)


def test_the_environment_speaks_only_where_nobody_else_has(monkeypatch):
    monkeypatch.setenv(WORKERS, "2")
    assert alone(range(5)) == alone_in_one(5)
    monkeypatch.setenv(WORKERS, "many")
    assert alone_in_one(5), "a caller's own choice wins"
    for said in ("many", "0", "1.5"):
        monkeypatch.setenv(WORKERS, said)
        with pytest.raises(ValueError, match=f"other than 0, got '{said}'"):
            alone(range(5))
    monkeypatch.setenv(WORKERS, "-1")  # as many as there are
    assert alone(range(5)) == alone_in_one(5)


def test_nothing_to_do_is_nothing():
    assert alone([]) == []


def fail(item, *, rng):
    raise ValueError(f"item {item} is bad")


def test_an_error_of_an_item_reaches_the_caller():
    with pytest.raises(ValueError, match="item 3 is bad"):
        sweep(fail, [3], rng=np.random.default_rng(0))
