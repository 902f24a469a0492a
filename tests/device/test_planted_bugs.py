"""Where memory faults are planted still stands in the kernels; `.ci/run` plants them, under Oclgrind."""

from __future__ import annotations

import pytest

from clrt.base.resources import kernel_folder
from tests.planted_bugs import BUGS


@pytest.mark.parametrize("name", BUGS)
def test_the_place_of_a_planted_fault_is_there(name: str) -> None:
    file, good, bad, _ = BUGS[name]
    text = (kernel_folder() / file).read_text()
    assert good in text and text.replace(good, bad) != text
