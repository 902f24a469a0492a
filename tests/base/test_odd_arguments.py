"""Arguments whose own methods fail, or that say more than their numbers do."""

from __future__ import annotations

import numpy as np
import pytest

import clrt
from clrt.base.arguments import names, vectors
from clrt.base.errors import show


class Failing:
    def __repr__(self) -> str:
        raise RuntimeError("mine")


def test_what_cannot_be_shown_is_named_by_its_class() -> None:
    assert show(Failing()) == "a Failing" and show(10**5000) == "a int"


def test_an_array_is_no_list_of_names() -> None:
    for value in (np.zeros((2, 3)), np.zeros(0), np.ma.masked_array([1.0, 2.0], mask=[0, 1])):
        with pytest.raises(clrt.ClrtError, match="it must be a list of names"):
            names("layers", value)


def test_masks_are_not_ignored() -> None:
    numbers = np.ma.masked_array([[0.0, 0.0, 4.0]], mask=[[0, 0, 1]])
    with pytest.raises(clrt.ClrtError, match="origins: 1 of its numbers are masked"):
        vectors("origins", numbers, np.float32)
    assert vectors("origins", np.ma.masked_array([[0.0, 0.0, 4.0]]), np.float32).shape == (1, 3)


def test_numbers_of_thousands_of_digits_are_refused() -> None:
    for wrong in ({10**5000: 1}, {"shapes": [{"type": 10**5000}]}):
        with pytest.raises(clrt.ClrtError):
            clrt.load_dict(wrong)
    with pytest.raises(clrt.ClrtError, match="local_size"):
        clrt.Settings(local_size=10**5000)
