import numpy as np
import pytest
from toy import ball


def test_a_ball(same_picture):
    same_picture(ball())


@pytest.mark.parametrize("light", [(-1, 0, 1), (0, 1, 0)], ids=["from the left", "from above"])
def test_other_lights(same_picture, light):
    verdict = same_picture(ball(light=light), gates={"SSIM": 0.999, "largest difference": 1e-3})
    assert verdict.figures["SSIM"] > 0.999


def test_bytes_and_floats(same_picture):
    shown = np.clip(255 * ball() ** (1 / 2.2) + 0.5, 0, 255).astype(np.uint8)
    same_picture(shown, "bytes")
    same_picture(ball() * 4, "bright floats")
