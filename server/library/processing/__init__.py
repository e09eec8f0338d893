"""The jobs on logs: reading, pictures, contents, SLAM, localization, merging, mapping of all logs."""
