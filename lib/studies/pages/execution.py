"""Pages are executed several at a time, each by a kernel of its own, before Sphinx reads them.

MyST-NB executes a page when it reads it, one after the other. Here its own client does so earlier,
into the cache where the reader of the page then finds the results.
"""

import logging
from collections.abc import Iterable, MutableMapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

from myst_nb.core.config import NbParserConfig
from myst_nb.core.execute import ExecutionError, create_client
from myst_nb.core.read import create_nb_reader
from myst_parser.config.main import MdParserConfig
from sphinx.util import logging as sphinx_logging

from studies.pages.forked import forked_kernels

_LOG = sphinx_logging.getLogger(__name__)


class _Told(logging.LoggerAdapter):
    """Says of which page a message is. None is a warning: who reads the page will warn."""

    def process(
        self, msg: str, kwargs: MutableMapping[str, Any]
    ) -> tuple[str, MutableMapping[str, Any]]:
        return f"{self.extra['page']}: {msg}", {}

    warning = logging.LoggerAdapter.info


def execute(
    pages: Iterable[tuple[Path, NbParserConfig]], config: MdParserConfig, kernels: int
) -> None:
    """Execute pages, so many at a time, in their order, unless their caches have their results.

    A page that fails leaves none: it is executed again when it is read, where the failure is told.
    """

    def run(page: Path, own: NbParserConfig) -> None:
        text = page.read_text("utf-8")
        reader = create_nb_reader(str(page), config, own, text)
        told = _Told(_LOG, {"page": page.stem})
        with suppress(ExecutionError):
            create_client(reader.read(text), str(page), own, told, reader.read_fmt).start_client()

    with forked_kernels(), ThreadPoolExecutor(kernels) as pool:
        for done in [pool.submit(run, *page) for page in pages]:
            done.result()
