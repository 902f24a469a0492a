"""Microbenchmarks: every pass alone on recorded queues, the builder, launches, compiling, whole frames.

`scenes` says on what, `recorder` records the launches of real passes, `timing` repeats them, `roof`
measures what the device could do at best, `report`, `verdict` and `chart` present it. `embree` is the
yardstick beside it, `scaling` follows one quantity at a time over orders of magnitude.
"""
