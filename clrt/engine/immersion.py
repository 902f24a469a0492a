"""The media that rays of generation 0 start in, told to the device."""

from __future__ import annotations

import numpy as np

from clrt.device.device import Device
from clrt.engine.queues import Queue, block_bytes
from clrt.engine.world import World


def immerse(
    device: Device,
    world: World,
    queue: Queue,
    origins: np.ndarray | None = None,
    within: np.ndarray | None = None,
) -> None:
    """Give rays of generation 0 the media that their origins lie in, where rays carry lists of them.

    origins: (n, 3), or (1, 3) where all rays have the same; None reads them from the queue, which takes time
    and is left out where no medium comes near `within`: points (m, 3) between which all rays start.
    """
    if world.flat.media is None:
        return
    n, lanes = queue.n, device.settings.lanes
    if within is not None and not world.flat.media.near(within):
        device.fill(queue.media, block_bytes(n, device.media, lanes), -1)
        return
    if origins is None:
        origins = queue.lines(queue.rays)["origin"].T
    media = world.flat.media.lists(origins)
    if (media < 0).all():
        device.fill(queue.media, block_bytes(n, device.media, lanes), -1)
        return
    places = np.full((-(-n // lanes) * lanes, device.media), -1, np.int32)
    places[:n] = media
    blocks = places.reshape(-1, lanes, device.media).transpose(0, 2, 1)
    device.write(queue.media, np.ascontiguousarray(blocks))
