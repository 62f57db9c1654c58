# SPDX-License-Identifier: Apache-2.0
"""The tests themselves: every module is collected, whatever optional libraries there are."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
MODULES = sorted(TESTS.rglob('*.py'))
OPTIONAL = {
    'dask', 'distributed', 'jsonschema', 'matplotlib', 'mcap', 'mujoco', 'numba', 'opensim',
    'playwright', 'pyarrow', 'pymoo', 'rich', 'viser', 'zstandard',
}  # fmt: skip


def module_level_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what runs when a module is imported: all but functions and `if TYPE_CHECKING`."""
    for child in ast.iter_child_nodes(node):
        typing_only = isinstance(child, ast.If) and ast.unparse(child.test) == 'TYPE_CHECKING'
        if not isinstance(child, ast.FunctionDef | ast.Lambda) and not typing_only:
            yield child
            yield from module_level_nodes(child)


def module_level_faults(source: str) -> list[str]:
    """Return what a test module must not do at its import."""
    faults = []
    for node in module_level_nodes(ast.parse(source)):
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith('importorskip'):
            faults.append(ast.unparse(node))
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        faults += [f'import {name}' for name in names if name.split('.')[0] in OPTIONAL]
    keywords = (node.arg for node in ast.walk(ast.parse(source)) if isinstance(node, ast.keyword))
    return faults + [arg for arg in keywords if arg == 'allow_module_level']


def test_no_module_skips_or_needs_an_optional_library_at_its_import() -> None:
    faults = {path.name: module_level_faults(path.read_text(encoding='utf-8')) for path in MODULES}
    assert {name: found for name, found in faults.items() if found} == {}


def test_a_skip_at_import_would_be_noticed() -> None:
    for fault in (
        "pytest.importorskip('pymoo')",
        "with warnings.catch_warnings():\n    pymoo = importorskip('pymoo')",
        "pytest.skip('no pymoo', allow_module_level=True)",
        'import matplotlib.pyplot as plt',
        'try:\n    from viser import uplot\nexcept ImportError:\n    pass',
    ):
        assert len(module_level_faults(fault)) == 1
    assert module_level_faults("def test_it() -> None:\n    pytest.importorskip('pymoo')") == []


def test_a_run_that_collects_too_few_tests_fails(tmp_path: Path) -> None:
    tests = tmp_path / 'test'
    tests.mkdir()
    shutil.copy(TESTS / 'conftest.py', tests)
    shutil.copy(TESTS.parent / 'pyproject.toml', tmp_path)
    (tests / 'test_one.py').write_text('def test_one() -> None:\n    pass\n')

    def run(*arguments: str) -> tuple[int, str]:
        command = [sys.executable, '-m', 'pytest', *arguments]
        env = {name: value for name, value in os.environ.items() if name != 'PYTEST_ADDOPTS'}
        ended = subprocess.run(command, cwd=tmp_path, env=env, capture_output=True, text=True)
        return ended.returncode, ended.stdout + ended.stderr

    code, text = run()
    assert code == pytest.ExitCode.USAGE_ERROR
    assert re.search(r'1 tests collected; there are \d+ at the least', text)
    assert run('-k', 'none')[0] == pytest.ExitCode.USAGE_ERROR
    assert run('test')[0] == run('--ignore', 'doc')[0] == 0  # some of them


def test_the_names_of_the_modules_are_unique() -> None:
    """Pytest imports the modules of all folders by their bare names."""
    names = Counter(path.name for path in MODULES if path.name != 'conftest.py')
    assert [name for name, count in names.items() if count > 1] == []


def test_no_module_takes_anything_from_a_test_module() -> None:
    taken = [
        f'{path.name}: {node.module}'
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
        if isinstance(node, ast.ImportFrom)
        and (node.module or '').startswith(('test_', 'conftest'))
    ]
    assert taken == []
