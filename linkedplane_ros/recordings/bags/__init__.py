# SPDX-License-Identifier: Apache-2.0
"""ROS 2 bags (rosbag2: sqlite3 and mcap): opened, their topics, their messages."""
