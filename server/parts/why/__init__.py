"""Why a cell is as it is: its state, and the readings that made it so; see :mod:`mapper.mapping.provenance`."""
