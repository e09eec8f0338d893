"""Puzzles: sessions of logs with a hidden fault, and how far each visitor is. Answers are checked here only."""
