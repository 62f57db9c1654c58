"""The report's chapters: text, tables and pictures."""
