"""Times since 1970, and the units in which programs mistakenly write times that are read as seconds."""

from __future__ import annotations

EPOCH_S = (6e8, 5e9)  #: a stamp between these is seconds since 1970: the years 1989 to 2128
UNITS = ((1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"))  #: units per second, and their name
