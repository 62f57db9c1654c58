# SPDX-License-Identifier: Apache-2.0
"""Tables of motion: OpenSim's .mot and .sto, and CSV, read in chunks."""
