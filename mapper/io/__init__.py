"""Reading and writing files: logs, maps and exports."""
