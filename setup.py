# SPDX-License-Identifier: Apache-2.0
"""Install linkedplane_ros, with colcon or with pip."""

from glob import glob

from setuptools import find_packages, setup

package_name = 'linkedplane_ros'
share = 'share/' + package_name

# The oldest versions that are tested (`make quick OLDEST=1`); Ubuntu 24.04 brings none older.
ros = [
    'ros-jazzy-rclpy>=7.1.6',
    'ros-jazzy-common-interfaces>=5.3.6',
    'ros-jazzy-rmw-fastrtps-cpp>=8.4.3',
]
fast = ['numba>=0.59.1']
tools = [
    'matplotlib>=3.6.3',
    'pyarrow>=15.0.0',
    'pymoo>=0.6.2',
    'rich>=13.7.1',
    'rosbags>=0.11.9',
    'scipy>=1.11.4',
]
viewer = ['viser>=1.1,<2']
cluster = ['dask[distributed]>=2024.1.1']
bench = ['mujoco>=3.6', 'opensim']

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
    install_requires=['setuptools', 'numpy>=1.26.4', 'PyYAML>=6.0.1'],
    extras_require={
        'ros': ros,
        'fast': fast,
        'tools': tools,
        'viewer': viewer,
        'cluster': cluster,
        'bench': bench,
        'all': ros + fast + tools + viewer,
        'test': ['pytest'],  # what colcon tests with; the rest is in test/requirements.txt
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
