from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.errors import BadFile
from mimeline.timeline.files import FORMATS, read, read_all, write, write_all
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import TRACKS

from .drawn import HOURS, RATES, kept, timelines, told_besides

EVERY_FORMAT = pytest.mark.parametrize("form", FORMATS.values(), ids=FORMATS)
EVERY_RATE = pytest.mark.parametrize("fps", RATES, ids=lambda rate: f"{float(rate):.3f}")
SEVERAL = pytest.mark.parametrize("form", ["json", "csv"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


def there_and_back(timeline, path):
    """What write says is lost, and what read gives."""
    lost = write(timeline, path)
    return lost, read(path, **told_besides(timeline, lost))


@EVERY_RATE
@EVERY_FORMAT
@settings(max_examples=10, deadline=None)
@given(data=st.data())
def test_a_timeline_comes_back_as_it_was_but_for_what_write_named(folder, form, fps, data):
    timeline = data.draw(timelines(fps))
    lost, back = there_and_back(timeline, folder / f"clip{form.suffixes[0]}")
    assert back == kept(timeline, lost)
    assert set(lost) <= form.loses


@EVERY_FORMAT
@settings(max_examples=10, deadline=None)
@given(data=st.data())
def test_a_timeline_that_was_read_is_written_as_the_same_bytes(folder, form, data):
    timeline = data.draw(timelines(data.draw(st.sampled_from(RATES))))
    path = folder / f"again{form.suffixes[0]}"
    _, once = there_and_back(timeline, path)
    lost, twice = there_and_back(once, path)
    first = path.read_bytes()
    write(twice, path)
    assert path.read_bytes() == first and once == kept(twice, lost)


@EVERY_RATE
@EVERY_FORMAT
@settings(max_examples=5, deadline=None)
@given(data=st.data())
def test_hours_do_not_move_a_frame(folder, form, fps, data):
    timeline = data.draw(timelines(fps, n_frames=round(fps * 3600 * HOURS)))
    lost, back = there_and_back(timeline, folder / f"long{form.suffixes[0]}")
    assert back == kept(timeline, lost)


@EVERY_RATE
@pytest.mark.parametrize("form", ["webvtt", "elan", "praat", "stmc"])
def test_edges_of_a_minute_come_back_from_seconds(folder, form, fps):
    n_frames = round(fps * 60)
    brow = [Interval("BrowUp", frame, frame + 1) for frame in range(0, n_frames, 3)]
    timeline = Timeline("clip", fps, n_frames, {"brow": brow})
    path = folder / f"clip{FORMATS[form].suffixes[0]}"
    lost = write(timeline, path)
    assert read(path, **told_besides(timeline, lost)) == timeline


@EVERY_FORMAT
@settings(max_examples=25, deadline=None)
@given(name=st.text(min_size=1))
def test_a_clip_of_any_name_is_written_whole_or_refused(folder, form, name):
    timeline = Timeline(name, Fraction(30), 9, {"brow": [Interval("BrowUp", 2, 5)]})
    path = folder / f"named{form.suffixes[0]}"
    try:
        lost = write(timeline, path)
    except BadFile as error:
        assert "clip" in error.found and ".json" in error.remedy
    else:
        assert read(path, **told_besides(timeline, lost)) == timeline


@SEVERAL
@settings(max_examples=6, deadline=None)
@given(data=st.data())
def test_several_clips_share_a_file(folder, form, data):
    drawn = [data.draw(timelines(fps, names=st.just(str(fps)))) for fps in RATES]
    path = folder / f"clips.{form}"
    lost = write_all(drawn, path)
    rates, lengths = ({t.clip_id: getattr(t, n) for t in drawn} for n in ("fps", "n_frames"))
    back = read_all(path, rates, lengths)
    whole = [t for t in drawn if any(t.tracks.values()) or "clips without intervals" not in lost]
    assert back == [kept(t, lost) for t in whole] or not whole
    for timeline in back if whole else ():
        told = told_besides(timeline, lost) | {"clip_id": timeline.clip_id}
        assert read(path, **told) == timeline


def test_clips_of_stmc_are_named_by_their_place(folder):
    fps, path = Fraction(25), folder / "mtt.txt"
    first = Timeline("a", fps, 50, {"brow": [Interval("BrowUp", 0, 9)]})
    second = Timeline("b", fps, 50, {"mouth": [Interval("Smile", 3, 9)]})
    assert "clip" in write_all([first, second], path)
    back = read_all(path, fps, 50)
    assert [(t.clip_id, t.tracks) for t in back] == [
        ("mtt_1", first.tracks),
        ("mtt_2", second.tracks),
    ]


@pytest.mark.parametrize("form", ["webvtt", "elan", "praat"])
def test_a_format_of_one_clip_refuses_two(folder, form):
    timeline = Timeline("a", Fraction(30), 9, {})
    with pytest.raises(BadFile, match="found 2 clips.*a file per clip"):
        write_all([timeline, timeline], folder / f"two{FORMATS[form].suffixes[0]}")


@SEVERAL
def test_a_clip_goes_into_a_file_once(folder, form):
    timeline = Timeline("a", Fraction(30), 9, {})
    with pytest.raises(BadFile, match='found clip "a" twice'):
        write_all([timeline, timeline], folder / f"twice.{form}")


@pytest.mark.parametrize("form", ["json", "webvtt", "elan", "praat"])
def test_neutral_throughout_is_not_the_same_as_not_measured(folder, form):
    timeline = Timeline("clip", Fraction(30), 90, {"brow": [], "mouth": [Interval("Smile", 1, 9)]})
    path = folder / f"clip{FORMATS[form].suffixes[0]}"
    lost = write(timeline, path)
    back = read(path, **told_besides(timeline, lost))
    assert list(back.tracks) == ["brow", "mouth"] and back.tracks["brow"] == ()
    assert "neutral tracks" not in lost


@pytest.mark.parametrize("form", ["csv", "stmc"])
def test_formats_of_intervals_alone_say_that_neutral_tracks_are_lost(folder, form):
    tracks = {"brow": [], "mouth": [Interval("Smile", 1, 9)]}
    path = folder / f"clip{FORMATS[form].suffixes[0]}"
    assert "neutral tracks" in write(Timeline("clip", Fraction(30), 90, tracks), path)
    assert "neutral tracks" not in write(
        Timeline("clip", Fraction(30), 90, {"mouth": tracks["mouth"]}), path
    )


@pytest.mark.parametrize("form", ["webvtt", "elan", "stmc"])
def test_more_frames_than_milliseconds_are_refused(folder, form):
    timeline = Timeline("clip", Fraction(1000), 9, {"brow": [Interval("BrowUp", 1, 2)]})
    path = folder / f"fast{FORMATS[form].suffixes[0]}"
    with pytest.raises(BadFile, match="milliseconds do not tell apart.*JSON"):
        write(timeline, path)
    assert not path.exists()


@pytest.mark.parametrize("form", FORMATS.values(), ids=FORMATS)
def test_a_clip_without_a_measured_track_comes_back(folder, form):
    timeline = Timeline("clip", Fraction(30), 9, {})
    path = folder / f"clip{form.suffixes[0]}"
    lost = write(timeline, path)
    assert read(path, **told_besides(timeline, lost)) == timeline


def test_files_keep_the_order_of_the_tracks(folder):
    tracks = {track: [] for track in reversed(TRACKS)}
    path = folder / "clip.eaf"
    write(Timeline("clip", Fraction(30), 9, tracks), path)
    assert tuple(read(path).tracks) == TRACKS
