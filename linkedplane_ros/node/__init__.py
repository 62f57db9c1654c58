"""The ROS node: topics, parameters, diagnostics, messages."""
