# SPDX-License-Identifier: Apache-2.0
"""The package as it is installed: what it names and what it needs."""

import ast
import configparser
import importlib.metadata
import re
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import pytest
from minimal_python import run_python
from setuptools import find_packages

import linkedplane_ros

TOP = Path(__file__).resolve().parents[2]
SOURCES = TOP / 'linkedplane_ros'
PURE = [
    path.relative_to(SOURCES).with_suffix('').as_posix().replace('/', '.')
    for path in sorted(SOURCES.rglob('*.py'))
    if path.relative_to(SOURCES).parts[0] not in ('node', 'viewer', 'commands')
]


PURE += [f'commands.{name}' for name in ('fit', 'info', 'main', 'plot', 'process', 'solve')]


PURE += [f'commands.{name}' for name in ('study', 'argument_types')]


PURE += [f'node.{name}' for name in ('parameters', 'settings', 'topics')]


PURE += ['viewer.newest']


PURE += [f'viewer.scene.{name}' for name in ('colour_map', 'geometry', 'wire')]


PURE += [f'viewer.panels.{name}' for name in ('history', 'motions', 'table')]
SCRIPTS = ('muscle_state_publisher', 'muscle_viewer', 'linkedplane', 'linkedplane_demo')


def is_of_ros(module: str) -> bool:
    return module in {'launch', 'rclpy'} or module.endswith(('_msgs', '_interfaces', '_ros'))


def ros_imports(source: Path) -> set[str]:
    """Return the ROS packages that a file imports, at its top or anywhere inside."""
    found = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split('.')[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module.split('.')[0])
    return {module for module in found if is_of_ros(module)} - {'linkedplane_ros'}


def setup_arguments() -> dict[str, ast.expr]:
    call = next(
        node
        for node in ast.walk(ast.parse((TOP / 'setup.py').read_text()))
        if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'setup'
    )
    return {keyword.arg: keyword.value for keyword in call.keywords if keyword.arg}


def console_scripts() -> dict[str, str]:
    points = ast.literal_eval(setup_arguments()['entry_points'])
    return dict(re.split(r'\s*=\s*', line) for line in points['console_scripts'])


def declared(tag: str) -> set[str]:
    root = ElementTree.parse(TOP / 'package.xml').getroot()
    return {element.text or '' for element in root.iter(tag)}


def test_all_files_give_the_same_version() -> None:
    (version,) = declared('version')
    assert ast.literal_eval(setup_arguments()['version']) == version
    assert linkedplane_ros.__version__ == version
    released = re.findall(r'^(\d+\.\d+\.\d+)\b', (TOP / 'CHANGELOG.rst').read_text(), re.MULTILINE)
    assert released[0] == version


def test_package_xml_and_setup_py_say_the_same() -> None:
    (maintainer,) = ElementTree.parse(TOP / 'package.xml').getroot().iter('maintainer')
    arguments = setup_arguments()
    assert ast.literal_eval(arguments['maintainer']) == maintainer.text
    assert ast.literal_eval(arguments['maintainer_email']) == maintainer.get('email')
    assert {ast.literal_eval(arguments['license'])} == declared('license')
    assert {ast.literal_eval(arguments['description'])} == declared('description')


def test_setup_py_installs_every_folder_of_modules() -> None:
    given = {
        'find_packages': partial(find_packages, str(TOP)),
        'package_name': 'linkedplane_ros',
    }
    packages = eval(ast.unparse(setup_arguments()['packages']), given)
    modules = (path.relative_to(TOP) for path in SOURCES.rglob('*.py'))
    assert set(packages) == {'.'.join(module.parent.parts) for module in modules}


def test_setup_py_names_the_executables() -> None:
    assert set(console_scripts()) == set(SCRIPTS)


@pytest.mark.parametrize('script', SCRIPTS)
def test_every_executable_has_its_function(script: str) -> None:
    module, function = console_scripts()[script].split(':')
    source = TOP / (module.replace('.', '/') + '.py')
    assert function in {
        node.name
        for node in ast.parse(source.read_text()).body
        if isinstance(node, ast.FunctionDef)
    }


def test_the_installed_package_has_the_executables_of_setup_py() -> None:
    points = importlib.metadata.distribution('linkedplane_ros').entry_points
    assert {point.name: point.value for point in points} == console_scripts()


def test_scripts_go_where_ros2_run_looks() -> None:
    config = configparser.ConfigParser()
    config.read(TOP / 'setup.cfg')
    assert config['develop']['script_dir'] == '$base/lib/linkedplane_ros'
    assert config['install']['install_scripts'] == '$base/lib/linkedplane_ros'


@pytest.mark.parametrize('module', PURE)
def test_a_pure_module_names_no_ros_package(module: str) -> None:
    source = SOURCES.joinpath(*module.split('.')).with_suffix('.py')
    assert ros_imports(source) == set()


def test_pure_modules_load_no_ros_package() -> None:
    code = 'import sys\n'
    code += ''.join(f'import linkedplane_ros.{module}\n' for module in PURE)
    code += 'print(*{name.split(".")[0] for name in sys.modules})'
    result = run_python(code, LINKEDPLANE_COMPILE='0')
    assert result.returncode == 0, result.stderr
    assert {name for name in result.stdout.split() if is_of_ros(name)} == {'linkedplane_ros'}


def test_package_xml_declares_just_the_ros_packages_that_are_imported() -> None:
    sources = [*SOURCES.rglob('*.py'), *TOP.glob('launch/*.py')]
    imported = set().union(*map(ros_imports, sources))
    started = {'tf2_ros'}  # by a launch file
    assert {name for name in declared('exec_depend') if is_of_ros(name)} == imported | started


def test_package_xml_declares_what_launch_files_start_and_pages_call() -> None:
    sources = [*TOP.glob('launch/*.py'), *SOURCES.glob('node/launching/*.py')]
    started = {
        package
        for source in sources
        for package in re.findall(r"package='(\w+)'", source.read_text(encoding='utf-8'))
    }
    assert started >= {'rviz2', 'tf2_ros'}
    commands = {
        f'ros2{command}'
        for page in (TOP / 'README.md', *TOP.glob('doc/**/*.md'))
        for line in page.read_text(encoding='utf-8').splitlines()
        if line.startswith('$ ')
        for command in re.findall(r'\bros2 ([a-z]+) ', line)
    }
    assert commands >= {'ros2bag', 'ros2launch'}
    assert declared('exec_depend') >= (started | commands) - {'linkedplane_ros'}
