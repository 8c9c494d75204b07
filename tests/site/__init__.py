"""The site in a real browser; what breaks off in a visit says what it compared."""

import pytest

pytest.register_assert_rewrite("tests.site.scorecard", "tests.site.driver")
