"""The pictures of a series in their order, made by one Tracer or by many workers."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import closing
from typing import Any, Protocol

from clrt.cluster.pictures import Plan, Remote, Sheet
from clrt.device.settings import Settings
from clrt.engine.request import Request
from clrt.engine.tracer import Tracer
from clrt.images.image import Image
from clrt.scene.scene import Scene, edited

Values = dict[str, Any]


class Maker(Protocol):
    """Who makes pictures. `turn_to` is asked about each before `images` takes it, in the same order."""

    def turn_to(self, index: int, scene: Scene) -> str:
        """What identifies the picture of that number, which shows this scene."""

    def images(self, wanted: Iterable[int], most: int) -> Generator[tuple[int, Image]]:
        """The pictures of these numbers, of which there are at most so many."""


class Frames:
    """A series: the scene, and the values that change for each picture."""

    def __init__(self, maker: Maker, scene: Scene, series: list[Values], report: Any) -> None:
        self.maker, self.scene, self.series, self.report = maker, scene, series, report
        self._rays = self._done = 0

    def images(self, is_there: Callable[[int, str], bool]) -> Iterator[tuple[int, Image]]:
        """All pictures that are not there yet, as `is_there` says of a number and what identifies it."""

        def wanted() -> Iterator[int]:
            for index, values in enumerate(self.series):
                if is_there(index, self.maker.turn_to(index, edited(self.scene, values))):
                    self._told()
                else:
                    yield index

        with closing(self.maker.images(wanted(), len(self.series))) as made:
            for index, image in made:
                self._rays += image.stats["traced"]
                self._told()
                yield index, image

    def _told(self) -> None:
        self._done += 1
        if self.report:
            self.report(self._done, len(self.series), self._rays)


class OneTracer:
    """One after the other, here. picture: as `Tracer.render` takes it."""

    def __init__(self, tracer: Tracer, picture: Mapping[str, Any]) -> None:
        self.tracer, self.picture = tracer, picture

    def turn_to(self, index: int, scene: Scene) -> str:
        self.tracer.update(scene)
        return self.tracer.identity(**self.picture)

    def images(self, wanted: Iterable[int], most: int) -> Generator[tuple[int, Image]]:
        for index in wanted:
            yield index, self.tracer.render(**self.picture)


class Workers:
    """Several at a time, by an executor's workers."""

    def __init__(
        self, executor: Any, device: int | str | None, settings: Settings, picture: Mapping[str, Any]
    ) -> None:
        self.remote, self.asked = Remote(executor, device, settings), Request(**picture)
        self._plans: dict[int, Plan] = {}

    def turn_to(self, index: int, scene: Scene) -> str:
        plan = self.remote.plan(scene, self.asked)
        self._plans = {index: plan}  # the one before has been taken, or was not wanted
        job, window = plan[2], plan[4]
        return job.fingerprint(window)

    def images(self, wanted: Iterable[int], most: int) -> Generator[tuple[int, Image]]:
        numbers: dict[Sheet, int] = {}

        def sheets() -> Iterator[Sheet]:
            for index in wanted:
                sheet = Sheet(*self._plans[index])
                numbers[sheet] = index
                yield sheet

        with closing(self.remote.sheets(sheets(), most)) as done:
            for sheet in done:
                yield numbers.pop(sheet), sheet.image()
