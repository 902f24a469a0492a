"""Which media rays are in: every list of media that comes up is a state, known by its number.

A state is a tuple of media, numbered as in the job, in the order in which a ray entered them; surroundings
are state 0. What happens at a boundary is worked out once for each state, medium and side.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray
State = tuple[int, ...]


class Media:
    """states: those that rays start in, surroundings first.

    job: `number` (shapes + 1,), the medium that a shape bounds or -1, and `priority`, `eta` (media,) and
    `sigma` (media, 3), of which the last row is the surroundings.
    """

    def __init__(self, job: dict[str, Any], states: list[State]) -> None:
        self.number, self.priority = job["number"], job["priority"]
        self.eta, self.sigma = job["eta"], job["sigma"]
        self._states: list[State] = []
        self._places: dict[State, int] = {}
        self._known: dict[tuple[int, int, bool, bool], tuple[int, int]] = {}
        for state in states:
            self._place(state)

    def _place(self, state: State) -> int:
        if state not in self._places:
            self._places[state] = len(self._states)
            self._states.append(state)
        return self._places[state]

    def top(self, states: Array) -> Array:
        """The medium (n,) that counts in states (n,); -1, the last row, for the surroundings."""
        tops = [max(enumerate(state), key=self._rank, default=(0, -1))[1] for state in self._states]
        return np.array(tops)[states]

    def _rank(self, entry: tuple[int, int]) -> tuple[float, int]:
        place, medium = entry
        return self.priority[medium], place

    def times(self, states: Array, medium: Array) -> Array:
        """How often (n,) states list media."""
        pairs = zip(states.tolist(), medium.tolist(), strict=True)
        return np.array([self._states[state].count(number) for state, number in pairs], int)

    def across(self, states: Array, shapes: Array, enters: Array, beside: Array) -> tuple[Array, Array]:
        """States on this side and beyond surfaces of shapes (n,), as a ray in these states meets them.

        beside: where it has just crossed an edge by the other side, or only touches one.
        """
        met = np.stack([states, self.number[shapes], enters, beside])
        kinds, row = np.unique(met, axis=1, return_inverse=True)
        pairs = [self._across(int(k[0]), int(k[1]), bool(k[2]), bool(k[3])) for k in kinds.T]
        found = np.array(pairs, int).reshape(-1, 2)[row.ravel()]
        return found[:, 0], found[:, 1]

    def _across(self, place: int, medium: int, enters: bool, beside: bool) -> tuple[int, int]:
        key = place, medium, enters, beside
        if key not in self._known:
            self._known[key] = self._worked_out(*key)
        return self._known[key]

    def _worked_out(self, place: int, medium: int, enters: bool, beside: bool) -> tuple[int, int]:
        state = self._states[place]
        if medium < 0 or beside:
            return place, place
        if enters:
            return place, self._place((*state, medium))
        if medium not in state:  # it was there all the time
            return self._place((*state, medium)), place
        latest = len(state) - 1 - state[::-1].index(medium)
        return place, self._place(state[:latest] + state[latest + 1 :])
