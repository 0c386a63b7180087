"""What is told of a scene before it is rendered."""

import numpy as np

from ...issues import IssueLog
from ...scene.data import Image
from ...settings import Settings
from ..summary import summarize, summary_text
from .fake import triangle_scene


def test_images_with_their_memory():
    scene = triangle_scene()
    scene.images = [Image("Bark", np.zeros((500, 250, 4), np.float32)), Image("Elsewhere")]
    record = summarize(scene, Settings(), IssueLog())
    assert record["image_mb"] == 2.0
    assert "images:    Bark, Elsewhere: 2 MB" in summary_text(record, IssueLog())
