"""Inputs made to break the loaders and the renderer: any of them must render, or end in one `ClrtError`.

`seeds` are good files of every format, `mutate` spoils them (by their structure, by their words, by their
bytes), `worker` reads and renders one after another in a process of its own, `run` watches the workers' time
and memory. `corpus/` keeps what was written by hand and what was once found; every file in it is tried, too.
"""
