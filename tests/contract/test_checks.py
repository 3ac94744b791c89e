"""What all checks of `multilayer.testing` have in common."""

import ast
from pathlib import Path

import pytest

from multilayer import testing


@pytest.mark.parametrize("file", sorted(Path(testing.__file__).parent.glob("*.py")), ids=lambda file: file.stem)
def test_a_check_checks_where_python_leaves_out_assertions(file):
    """Under ``python -O`` an assert statement does nothing."""
    assert [node.lineno for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Assert)] == []
