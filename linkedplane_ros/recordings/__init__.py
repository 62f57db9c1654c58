"""Motion from files: bags, OpenSim's tables and CSV, as angles over time."""
