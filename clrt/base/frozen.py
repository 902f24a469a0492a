"""A dict that stays as it was made: what has been checked once must not change behind its back."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

from clrt.base.errors import ClrtError

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(dict[K, V]):
    """Equal to a dict of the same items, and copied and pickled as one; ClrtError where it would change.

    (A `types.MappingProxyType` can be neither copied nor pickled.)
    """

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise ClrtError("this dict stays as it is; dict(...) makes a copy to change, for a new scene")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)
