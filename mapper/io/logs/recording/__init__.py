"""The log of a robot made of a recording's messages: streams, clocks, frames, poses and scans."""
