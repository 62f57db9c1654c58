# SPDX-License-Identifier: Apache-2.0
"""Install linkedplane_ros, with colcon or with pip."""

from glob import glob

from setuptools import find_packages, setup

package_name = 'linkedplane_ros'
share = 'share/' + package_name

ros = [
    'ros-jazzy-rclpy',
    'ros-jazzy-common-interfaces',
    'ros-jazzy-rmw-fastrtps-cpp',
]
fast = ['numba']
tools = ['matplotlib', 'pyarrow', 'pymoo>=0.6.2', 'rich', 'rosbags', 'scipy']
viewer = ['viser>=1.1,<2']
cluster = ['dask[distributed]']
docs = ['furo>=2024.8.6', 'myst-parser>=4', 'sphinx>=8.1']
bench = ['mujoco>=3.6', 'opensim']
test = [
    'colcon-bash',
    'colcon-output',
    'colcon-ros',
    'colcon-test-result',
    'hypothesis',
    'jsonschema',
    'mypy',
    'playwright',
    'pytest',
    'pytest-rerunfailures',
    'pytest-xdist',
    'ruff',
    'types-PyYAML',
]

setup(
    name=package_name,
    version='0.1.0',
    packages=find_packages(include=[package_name, package_name + '.*']),
    package_data={package_name: ['literature/*', 'models/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        (share, ['package.xml']),
        (share + '/config', glob('config/*')),
        (share + '/launch', glob('launch/*.py')),
        (share + '/msg_examples', glob('msg_examples/*.yaml')),
        (share + '/msg_examples/arm_raise', glob('msg_examples/arm_raise/*')),
    ],
    install_requires=['setuptools', 'numpy', 'PyYAML'],
    extras_require={
        'ros': ros,
        'fast': fast,
        'tools': tools,
        'viewer': viewer,
        'cluster': cluster,
        'bench': bench,
        'docs': docs,
        'all': ros + fast + tools + viewer,
        'test': test + cluster,
    },
    python_requires='>=3.10',
    zip_safe=False,
    author='The linkedplane_ros maintainers',
    maintainer='The linkedplane_ros maintainers',
    maintainer_email='maintainers@linkedplane-ros.example.org',
    description='Muscle paths of the deltoid by linked-plane obstacle sets, as a ROS 2 node',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'muscle_state_publisher = linkedplane_ros.node.__main__:main',
            'muscle_viewer = linkedplane_ros.viewer.__main__:main',
            'linkedplane = linkedplane_ros.commands.main:main',
            'linkedplane_demo = linkedplane_ros.commands.demo:main',
        ],
    },
)
