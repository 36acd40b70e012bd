from types import SimpleNamespace

import pytest

from mimeline.errors import BadFile, NoSuchFile
from mimeline.tracking.matching import Results
from mimeline.tracking.readers import Tracker


@pytest.fixture
def results(tmp_path) -> Results:
    options = {"folder": ".", "fps": "30", "timecode_base": 60, "angle_unit": "radians"}
    return Results(Tracker.of(tmp_path, "livelink", options, "fail"), None)


def part(number: int, source: str = "source") -> SimpleNamespace:
    """A clip of a tenth of a second."""
    times = {"start_s": 0.1 * number, "end_s": 0.1 * (number + 1)}
    return SimpleNamespace(clip_id=f"{source}_{number}", source_id=source, **times)


def test_a_source_that_cannot_be_read_is_not_read_again_for_each_of_its_clips(
    results, livelink_rows, tmp_path
):
    livelink_rows.assign(JawOpen="text").to_csv(tmp_path / "source.csv", index=False)
    livelink_rows.to_csv(tmp_path / "good.csv", index=False)
    with pytest.raises(BadFile) as first:
        results.of(part(0))
    assert len(results.of(part(0, "good")).take.motion) == 3
    livelink_rows.to_csv(tmp_path / "source.csv", index=False)
    with pytest.raises(BadFile) as second:
        results.of(part(1))
    assert second.value is first.value
    assert results.names == {"source.csv", "good.csv"} and set(results.errors) == {"source.csv"}


def test_a_clip_without_a_result_says_what_was_looked_for(results):
    with pytest.raises(NoSuchFile, match="of the clip or of source"):
        results.of(part(0))
    assert not results.names and not results.errors
