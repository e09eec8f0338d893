"""Puzzles: sessions of logs with a hidden fault, and each visitor's progress. Answers are checked only here."""
