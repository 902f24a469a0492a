"""The thesis program's pictures, computed anew, with or without its faults."""
