"""The web service: sessions, the tile stream, uploads, the 3D scenes and the command line."""
