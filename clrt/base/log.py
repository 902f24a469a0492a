"""What clrt is doing, for those who ask: `logging.getLogger("clrt")`, silent until it gets a handler."""

from __future__ import annotations

import logging

log = logging.getLogger("clrt")
log.addHandler(logging.NullHandler())
