"""What sessions compute: one file for each kind, its helpers beside it."""
