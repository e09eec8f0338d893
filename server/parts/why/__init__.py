"""Why a cell has its state: the state, and the readings that led to it; see :mod:`mapper.mapping.provenance`."""
