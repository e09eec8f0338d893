"""Costmaps on top of a map: layers of costs as Nav2 has them."""
