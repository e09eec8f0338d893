"""Commands that estimate and evaluate poses."""
