"""`python -m linkedplane_ros.viewer`: the executable muscle_viewer."""

from ..executables import muscle_viewer

muscle_viewer()
