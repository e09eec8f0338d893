"""Parameter files of Nav2's costmaps: what they describe, their filters, reading and writing."""
