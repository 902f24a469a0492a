"""Pieces of work that go on side by side: all are done, each on a track of its own, large ones in parts."""

from __future__ import annotations

import numpy as np
import pytest

import clrt
from clrt.device.device import TRACKS, Device
from clrt.device.tracks import seconds_by_name
from clrt.engine.queues import picture_tile
from clrt.engine.schedule import TooLarge, Work, complete, interleaved

LARGEST = 30


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(settings=clrt.Settings(limits=clrt.Limits(device_bytes=1 << 20)))


def halved(array: np.ndarray) -> list[np.ndarray]:
    return [array[len(array) // 2 :], array[: len(array) // 2]]


def mean_of_halves(device: Device, array: np.ndarray) -> Work[np.ndarray]:
    """Half of every value, by a kernel; waits once before, for nothing, and once for the answer."""
    buffer = device.upload(array, wait=False)
    yield device.ask(buffer, np.empty_like(array))
    if len(array) > LARGEST:
        raise TooLarge
    device.launch("resolve", len(array), np.uint32(len(array)), np.float32(2), buffer)
    answer = device.ask(buffer, np.empty_like(array))
    yield answer
    return answer.wait()


def test_every_piece_is_done_and_too_large_ones_are_split(device: Device) -> None:
    values = np.random.default_rng(1).random(500, np.float32)
    pieces = [np.flatnonzero(part) for part in np.arange(500) % 7 == np.arange(7)[:, None]]
    assert any(len(piece) > LARGEST for piece in pieces)
    found = np.zeros_like(values)
    running: list[int] = []

    def work(track: Device, piece: np.ndarray) -> Work[np.ndarray]:
        running.append(len(piece))
        assert len(running) <= TRACKS
        try:
            return (yield from mean_of_halves(track, values[piece]))
        finally:
            running.pop()

    for piece, result in interleaved(device, pieces, work, halved):
        assert len(piece) <= LARGEST
        found[piece] = result
    assert np.array_equal(found, values / 2)
    assert not pieces


def test_small_pictures_are_cut_in_few_parts_of_at_most_two_tiles() -> None:
    """Whose memory is that of the largest tiles before: nothing more is given up and begun again."""
    tile = 100
    parts = {rays: -(-rays // picture_tile(rays, tile)) for rays in (50, 51, 200, 400, 401, 518, 600, 601)}
    assert parts == {50: 1, 51: 2, 200: 2, 400: 2, 401: 3, 518: 3, 600: 3, 601: 7}
    assert all(picture_tile(rays, tile) <= 2 * tile for rays in range(1, 1000))


def test_a_track_reuses_no_memory_that_another_still_works_on(device: Device) -> None:
    other = device.on(1)
    kept = other.buffer(1000)
    first = device.buffer(1000)
    number = first.int_ptr
    del first
    assert other.buffer(1000).int_ptr != number
    assert device.on(1).track is other.track is not device.on(0).track is device.track
    assert device.buffer(1000).int_ptr == number
    assert device.held_bytes >= 2 * kept.size
    with pytest.raises(clrt.LimitError, match="device_bytes"):
        device.buffer(1 << 20)


def test_work_can_be_done_alone(device: Device) -> None:
    values = np.arange(20, dtype=np.float32)
    assert np.array_equal(complete(mean_of_halves(device, values)), values / 2)
    with pytest.raises(TooLarge):
        complete(mean_of_halves(device, np.zeros(LARGEST + 1, np.float32)))


def test_time_in_which_two_kernels_work_counts_once() -> None:
    spans = [(0, 10, "a"), (20, 50, "b"), (40, 70, "c"), (45, 60, "a"), (70, 80, "b")]
    assert seconds_by_name(spans) == pytest.approx({"a": 10e-9, "b": 40e-9, "c": 20e-9})


def test_a_small_picture_is_two_tiles_and_a_large_one_many() -> None:
    tracer = clrt.Tracer(clrt.load_dict({"camera": {"origin": [0, 0, 5], "target": [0, 0, 0]}}))
    sizes = ((256, 256, 1), (257, 256, 2), (1024, 512, 2), (1025, 512, 3), (1537, 512, 7))
    for width, height, tiles in sizes:
        done: list[int] = []
        tracer.render(width, height, progress=lambda pixels, total, rays, done=done: done.append(pixels))
        assert (len(done), tracer.tile) == (tiles, 1 << 17), (width, height)
