"""The package as it is installed: what it names, what it needs, what its executables stand on."""

import ast
import configparser
import importlib.metadata
import os
import re
import subprocess
import sys
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import pytest
from setuptools import find_packages

import linkedplane_ros
from linkedplane_ros.node import environment

TOP = Path(__file__).resolve().parents[2]
SOURCES = TOP / 'linkedplane_ros'
PURE = [
    path.relative_to(SOURCES).with_suffix('').as_posix().replace('/', '.')
    for path in sorted(SOURCES.rglob('*.py'))
    if path.relative_to(SOURCES).parts[0] not in ('node', 'viewer', 'commands')
]
PURE += [f'commands.{name}' for name in ('fit', 'info', 'main', 'plot', 'process', 'solve')]
PURE += [f'commands.{name}' for name in ('study', 'values')]
PURE += [f'node.{name}' for name in ('parameters', 'settings', 'topics')]
PURE += ['viewer.newest']
PURE += [f'viewer.scene.{name}' for name in ('colour_map', 'geometry', 'wire')]
PURE += [f'viewer.panels.{name}' for name in ('history', 'motions', 'table')]
SCRIPTS = ('muscle_state_publisher', 'muscle_viewer', 'linkedplane', 'linkedplane_demo')
ENVIRONMENT = SOURCES / 'node' / 'environment.py'
PREPARE = f"import runpy; runpy.run_path('{ENVIRONMENT}')['prepare'](); "
RCLPY_RUNS = PREPARE + "import rclpy; rclpy.init(); rclpy.shutdown(); print('rclpy runs')"


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


def run_python(code: str, *options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run code in Python with a minimal environment."""
    return subprocess.run(
        [sys.executable, *options, '-c', code],
        env={'PATH': os.defpath, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', **environment},
        cwd=TOP,
        capture_output=True,
        text=True,
        timeout=60,
    )


# What it names


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


# What it needs


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


# What its executables stand on: each repair that environment makes, and each that it cannot

from_pypi = pytest.mark.skipif(
    not environment.library_folders(), reason='ROS is not from PyPI here: nothing to repair'
)


@from_pypi
def test_libraries_are_found_where_only_the_bootstrappers_mark_was_inherited(
    tmp_path: Path,
) -> None:
    variables = {'HOME': str(tmp_path), environment.BOOTSTRAPPED: '1'}
    assert run_python('import rclpy', **variables).returncode != 0
    result = run_python(RCLPY_RUNS, **variables)
    assert (result.returncode, result.stdout) == (0, 'rclpy runs\n'), result.stderr


@from_pypi
def test_libraries_are_found_where_no_bootstrapper_ran(tmp_path: Path) -> None:
    packages = str(environment.library_folders()[1].parent)
    result = run_python(RCLPY_RUNS, '-S', HOME=str(tmp_path), PYTHONPATH=packages)
    assert (result.returncode, result.stdout) == (0, 'rclpy runs\n'), result.stderr


@from_pypi
def test_python_is_not_started_again_for_ever() -> None:
    """As if a wrapper had cleared LD_LIBRARY_PATH after the restart."""
    code = f'import os; os.environ["{environment.RESTARTED}"] = str(os.getpid()); ' + PREPARE
    result = run_python(code, **{environment.BOOTSTRAPPED: '1', 'HOME': '/tmp'})
    assert result.returncode == 1
    assert re.fullmatch(r'the libraries of ROS are not found: LD_LIBRARY_PATH .*\n', result.stderr)


@from_pypi
@pytest.mark.parametrize(
    'variables',
    [{}, {'HOME': ''}, {'HOME': '/dev/null'}, {'HOME': '/', 'ROS_LOG_DIR': '/dev/null/log'}],
    ids=['no home', 'empty home', 'home not writable', 'log folder not writable'],
)
def test_logs_go_to_a_temporary_folder_where_they_have_no_home(
    variables: dict[str, str], tmp_path: Path
) -> None:
    result = run_python(RCLPY_RUNS, TMPDIR=str(tmp_path), **variables)
    assert (result.returncode, result.stdout) == (0, 'rclpy runs\n'), result.stderr
    assert [path.name[:8] for path in tmp_path.iterdir()] == ['ros_log_']


@from_pypi
def test_logs_stay_where_the_user_wants_them(tmp_path: Path) -> None:
    folder = tmp_path / 'deep' / 'logs'
    code = PREPARE + "import os; print(os.environ['ROS_LOG_DIR'])"
    result = run_python(code, TMPDIR=str(tmp_path), ROS_LOG_DIR=str(folder))
    assert result.stdout.strip() == str(folder), result.stderr


@from_pypi
def test_a_middleware_that_is_not_installed_is_named_in_one_line() -> None:
    result = run_python(RCLPY_RUNS, HOME='/tmp', RMW_IMPLEMENTATION='rmw_cyclonedds_cpp')
    assert result.returncode == 1
    assert re.fullmatch(
        r'RMW_IMPLEMENTATION=rmw_cyclonedds_cpp is not installed: .*\n', result.stderr
    )


def test_a_machine_without_ros_is_told_how_to_get_it() -> None:
    result = run_python(PREPARE, '-S', '-E')
    assert result.returncode == 1
    assert re.fullmatch(
        r'rclpy is not installed: source /opt/ros/jazzy/setup\.bash, or pip install .*\n',
        result.stderr,
    )


def test_a_ros_installation_is_left_alone(tmp_path: Path) -> None:
    """Stand-ins suffice: only where the packages lie matters."""
    for name in environment.NEEDED:
        (tmp_path / name).mkdir()
        (tmp_path / name / '__init__.py').touch()
    code = 'import os; before = dict(os.environ); '
    code += PREPARE + "print('unchanged' if dict(os.environ) == before else os.environ)"
    result = run_python(
        code, '-S', PYTHONPATH=str(tmp_path), RMW_IMPLEMENTATION='rmw_cyclonedds_cpp'
    )
    assert result.stdout == 'unchanged\n', result.stderr


# What colcon makes of it


@pytest.fixture
def prefix() -> Path:
    """Return where colcon has installed the package."""
    for entry in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        if Path(entry, 'lib', 'linkedplane_ros').is_dir():
            return Path(entry)
    pytest.skip('no built workspace is sourced; `make workspace` builds one and runs this')


@pytest.mark.workspace
def test_the_workspace_has_all_executables(prefix: Path) -> None:
    found = {path.name for path in (prefix / 'lib' / 'linkedplane_ros').iterdir()}
    assert found == set(SCRIPTS)


@pytest.mark.workspace
def test_executables_run_from_a_sourced_workspace_with_the_python_that_built_it(
    prefix: Path, tmp_path: Path
) -> None:
    executable = prefix / 'lib' / 'linkedplane_ros' / 'linkedplane'
    shebang = executable.read_text().splitlines()[0]
    assert Path(shebang.removeprefix('#!')).samefile(sys.executable)
    command = f'. "{prefix}/share/linkedplane_ros/package.sh" && cd / && "{executable}" info'
    result = subprocess.run(
        ['sh', '-c', command],
        env={'PATH': os.defpath, 'HOME': str(tmp_path), 'LINKEDPLANE_COMPILE': '0'},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert result.returncode == 0, result.stderr
    assert 'deltoid' in result.stdout


@pytest.mark.workspace
def test_the_workspace_has_all_shared_files(prefix: Path) -> None:
    share = prefix / 'share' / 'linkedplane_ros'
    for pattern in ('config/*', 'launch/*.py', 'msg_examples/*.yaml', 'msg_examples/*/*'):
        for source in TOP.glob(pattern):
            if source.is_file() and '__pycache__' not in source.parts:
                assert (share / source.relative_to(TOP)).is_file(), source
    assert (share / 'package.xml').is_file()
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    assert (index / 'linkedplane_ros').is_file()


@pytest.mark.workspace
@pytest.mark.parametrize('folder', ['literature', 'models'])
def test_the_workspace_has_the_models_and_the_literature(prefix: Path, folder: str) -> None:
    (installed,) = prefix.glob(f'lib/python*/site-packages/linkedplane_ros/{folder}')
    names = {path.name for path in (SOURCES / folder).iterdir()}
    assert {path.name for path in installed.iterdir()} == names
