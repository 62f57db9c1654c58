# SPDX-License-Identifier: Apache-2.0
"""Write a bag as rosbag2 does (metadata version 9), each topic with the facts it was recorded with.

The Writer of rosbags 0.11.9 is not used: it takes no topic without a definition or a hash of its
type, no other encoding than ros2msg and ros2idl, no two connections of one topic, and writes the
quality of service anew.
"""
