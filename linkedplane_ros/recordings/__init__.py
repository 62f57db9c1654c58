# SPDX-License-Identifier: Apache-2.0
"""Motion from files: bags, OpenSim's tables and CSV, as angles over time."""
