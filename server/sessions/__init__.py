"""Sessions: one grid each, with its parameters and its clock; a registry with budgets and eviction."""
