"""Log of a robot assembled from a recording's messages: streams, clocks, frames, poses and scans."""
