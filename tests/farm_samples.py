"""An executor that does at once what it is given, and a picture by its workers."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

import clrt
from clrt.cluster import pictures
from clrt.cluster.farm import Report
from clrt.cluster.orders import Order
from clrt.engine.request import Request

SIZE = {"width": 40, "height": 30, "max_depth": 2}


class Here(Executor):
    """Does at once what it is given; `before` and `after` may change orders and answers."""

    def __init__(
        self,
        before: Callable[[Order], Order] = lambda order: order,
        after: Callable[[Any], Any] = lambda answer: answer,
    ) -> None:
        self.before, self.after, self._max_workers = before, after, 2
        self.answers: list[Any] = []

    def submit(self, function: Any, /, *arguments: Any, **_: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            order = pickle.loads(pickle.dumps(self.before(arguments[0])))
            answer = pickle.loads(pickle.dumps(self.after(function(order))))
            self.answers.append(answer)
            future.set_result(answer)
        except BaseException as error:
            future.set_exception(error)
        return future


def done(executor: Executor, scene: clrt.Scene, **size: Any) -> tuple[clrt.Image, Report]:
    remote = pictures.Remote(executor, None, None)
    (sheet,) = remote.sheets(iter([pictures.Sheet(*remote.plan(scene, Request(**size)))]), 1)
    return sheet.image(), remote.farm.report


def same(one: clrt.Image, other: clrt.Image) -> None:
    assert one.hash == other.hash and one.wavelengths == other.wavelengths
    assert one.layers.keys() == other.layers.keys()
    for name, layer in one.layers.items():
        assert layer.dtype == other.layers[name].dtype and layer.tobytes() == other.layers[name].tobytes()
    for key in ("rays", "generations", "traced", "device", "local_size"):
        assert one.stats[key] == other.stats[key], key
    assert one.stats["seconds"].keys() >= {"closest", "gather"} <= other.stats["seconds"].keys()
    assert one.metadata == other.metadata
