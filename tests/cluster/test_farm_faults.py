"""Workers that differ, fail or cannot start, and executors that are no use: one ClrtError names them."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import kernel_folder
from clrt.cluster import worker
from clrt.cluster.orders import Order
from clrt.device.foreign import VARIABLE
from tests.farm_samples import SIZE, Here, done

pytestmark = pytest.mark.usefixtures("fresh")


def flip(order: Order) -> Order:
    if not order.arrays:
        return order
    name, array = next(iter(order.arrays.items()))
    changed = array.copy()
    changed.view(np.uint8).reshape(-1)[77] ^= 1
    return replace(order, arrays={**order.arrays, name: changed})


def other_recipe(order: Order) -> Order:
    return replace(order, scene="0" * 64)


REFUSED: dict[str, Callable[[Order], Order]] = {
    "it has clrt .*, the client 0.0.1": lambda order: replace(order, version="0.0.1"),
    "its kernels are others: .*, not 123": lambda order: replace(order, kernels="123"),
    "its scene is another one than was sent: .*, not 000000": other_recipe,
    "an array has changed on its way": flip,
    "device 'no such' is not here": lambda order: replace(order, device="no such"),
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_worker_that_differs_is_refused_by_name(text: str, mesh: clrt.Scene) -> None:
    with pytest.raises(clrt.ClrtError, match=rf"^worker \S+, process \d+: {text}") as caught:
        done(Here(REFUSED[text]), mesh, **SIZE)
    assert isinstance(caught.value, clrt.DeviceError) == ("device" in text)


def test_a_worker_that_fails_the_self_test_is_refused(
    mesh: clrt.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The verdict is kept for the machine, so that it is asked for once."""
    monkeypatch.undo()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    asked: list[None] = []
    for fault in ("spheres: 1 is 2", ""):
        monkeypatch.setattr(worker, "_fault", lambda device, fault=fault: asked.append(None) or fault)
        if fault:
            for _ in range(2):
                with pytest.raises(clrt.DeviceError, match=r"^worker .*: fails the self-test: spheres: 1"):
                    done(Here(), mesh, **SIZE)
            for file in (tmp_path / ".clrt" / "verdicts").iterdir():
                file.unlink()
        else:
            done(Here(), mesh, **SIZE)
    assert len(asked) == 2


def test_a_verdict_on_kernels_of_one_s_own_is_none_on_clrt_s(
    mesh: clrt.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    shutil.copytree(kernel_folder(), tmp_path / "kernels")
    with (tmp_path / "kernels" / "film.cl").open("a") as file:
        file.write("// mine\n")
    monkeypatch.setattr(worker, "_fault", lambda device: "not clrt's" if os.environ.get(VARIABLE) else "")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kernels"))
    with (
        pytest.warns(clrt.ClrtWarning, match=VARIABLE),
        pytest.raises(clrt.DeviceError, match="fails the self-test: not clrt's"),
    ):
        done(Here(), mesh, **SIZE)
    monkeypatch.delenv(VARIABLE)
    done(Here(), mesh, **SIZE)


def test_other_faults_name_the_worker_too(mesh: clrt.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "_traced", lambda *_: (_ for _ in ()).throw(MemoryError()))
    with pytest.raises(clrt.ClrtError, match=r"^worker .*: this machine has no memory left"):
        done(Here(), mesh, **SIZE)
    monkeypatch.setattr(worker, "_traced", lambda *_: {}["odd"])
    with pytest.raises(clrt.ClrtError, match=r"^a worker cannot do its work: KeyError: 'odd'"):
        done(Here(), mesh, **SIZE)


def end_all(*_: Any) -> None:
    raise BrokenProcessPool("a process ended")


def test_executors_that_are_broken_or_closed(mesh: clrt.Scene) -> None:
    with pytest.raises(clrt.ClrtError, match=r"^executor: its processes have ended \(a process ended\)"):
        done(Here(end_all), mesh, **SIZE)
    closed = ThreadPoolExecutor(1)
    closed.shutdown()
    with pytest.raises(clrt.ClrtError, match=r"^executor: cannot schedule new futures after shutdown; give"):
        done(closed, mesh, **SIZE)
    with pytest.raises(clrt.ClrtError, match=r"^executor: 3 is not allowed; it must be a concurrent.futures"):
        clrt.render(mesh, executor=3)  # type: ignore[arg-type]
    with pytest.raises(clrt.ClrtError, match=r"^checkpoint: it keeps one picture"):
        clrt.sweep(mesh, {"ambient": [0.1]}, executor=Here(), checkpoint="c")


def test_a_process_without_a_driver(mesh: clrt.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a process of its own, which is spawned."""
    monkeypatch.setenv("CLRT_DRIVER", "no such driver")
    text = r"^worker \S+, process \d+: CLRT_DRIVER='no such driver' is no driver"
    with (
        ProcessPoolExecutor(1, get_context("spawn")) as executor,
        pytest.raises(clrt.DeviceError, match=text),
    ):
        clrt.render(mesh, executor=executor, **SIZE)
