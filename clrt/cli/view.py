"""`clrt view`: a scene in a browser, on this machine only."""

from __future__ import annotations

import argparse

from clrt.base import interrupts
from clrt.base.errors import ClrtError
from clrt.cli.source import read, scene_path
from clrt.cli.terminal import say


def run(options: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C. ClrtError for a scene without a camera, and a port that is taken."""
    import clrt
    from clrt.formats.native import with_values
    from clrt.view.browser import opens
    from clrt.view.server import Server
    from clrt.view.session import Session

    if not 0 <= options.port < 1 << 16:
        raise ClrtError(f"--port: {options.port} is not allowed; it must be from 0 (a free one) to 65535")
    limits = clrt.Limits(**dict(options.limit))
    scene = with_values(read(scene_path(options.scene), limits), options.set)
    settings = clrt.Settings(threads=options.threads, limits=limits)
    # not closed at the end: that would wait for the picture that is under way
    session = Session(clrt.Tracer(scene, options.device, settings))
    with Server(session, options.port) as server:
        print(server.address, flush=True)
        if not options.browser:
            say("open this address in a browser on this machine; Ctrl-C ends it")
        elif opens(server.ticket):
            say("your browser shows it; Ctrl-C ends it")
        else:
            say("no browser was found: open this address in one on this machine; Ctrl-C ends it")
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            return say(f"{interrupts.word()}; the page has ended", interrupts.code())
    return 0
