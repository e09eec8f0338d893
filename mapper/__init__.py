"""The mapping core: occupancy grids from range scans. NumPy in, NumPy out; knows no web and no asyncio."""
