import cv2
import numpy as np
import pytest

from mimeline.media.picture import encode


@pytest.mark.parametrize(("kind", "error"), [("png", 0), ("webp", 12)])
def test_a_picture_keeps_its_colours(kind, error):
    picture = np.zeros((40, 60, 3), np.uint8)
    picture[:, :30] = (220, 120, 30)
    content = encode(picture, kind)
    back = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert np.abs(back[4:-4, 4:24].astype(int) - (220, 120, 30)).max() <= error
    assert content == encode(picture, kind)


def test_what_is_no_picture_is_refused():
    for wrong in (np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((4, 4, 4), np.uint8)):
        with pytest.raises(ValueError, match="uint8"):
            encode(wrong, "png")
    with pytest.raises(ValueError, match="kind"):
        encode(np.zeros((4, 4, 3), np.uint8), "bmp")
