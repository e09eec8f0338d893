"""Parameter files of Nav2's costmaps: description, filters, reading and writing."""
