"""One browser for the tests of a module."""

import pytest

from tests.explore.webdriver import browsing


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """Give one browser for all tests; each page has an origin of its own."""
    with browsing(tmp_path_factory.mktemp("browser")) as one:
        yield one
