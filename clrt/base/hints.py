"""What fields of records take, as type checkers see it.

A record may be made with lists, arrays, tables and other records, whatever its fields hold once a scene has
checked them. Those types stand beside these aliases, for msgspec, which reads them at run time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

Numbers: TypeAlias = Sequence[float] | np.ndarray
Rows: TypeAlias = Sequence[Any] | np.ndarray
"""Of numbers, or of what a list holds."""
Table: TypeAlias = Mapping[str, Any]
