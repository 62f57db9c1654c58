# SPDX-License-Identifier: Apache-2.0
"""What the launch files share: arguments -> the node that they make -> a recording played to it."""
