import xml.etree.ElementTree as ET
from fractions import Fraction
from math import floor

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pympi import Eaf

from mimeline.errors import BadFile
from mimeline.timeline.files import lint, read, write
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import TRACKS, track_actions

from .drawn import RATES, timelines

FPS = Fraction(30000, 1001)
# The children of each element in the schema's order (EAFv3.0.xsd); ELAN reads no other.
ORDER = {
    "ANNOTATION_DOCUMENT": [
        "LICENSE",
        "HEADER",
        "TIME_ORDER",
        "TIER",
        "LINGUISTIC_TYPE",
        "LOCALE",
        "LANGUAGE",
        "CONSTRAINT",
        "CONTROLLED_VOCABULARY",
        "LEXICON_REF",
        "EXTERNAL_REF",
    ],
    "HEADER": ["MEDIA_DESCRIPTOR", "LINKED_FILE_DESCRIPTOR", "PROPERTY"],
    "CONTROLLED_VOCABULARY": ["DESCRIPTION", "CV_ENTRY_ML"],
}
NEEDED = {
    "ANNOTATION_DOCUMENT": {"AUTHOR", "DATE", "FORMAT", "VERSION"},
    "MEDIA_DESCRIPTOR": {"MEDIA_URL", "MIME_TYPE"},
    "TIME_SLOT": {"TIME_SLOT_ID", "TIME_VALUE"},
    "TIER": {"TIER_ID", "LINGUISTIC_TYPE_REF"},
    "ALIGNABLE_ANNOTATION": {"ANNOTATION_ID", "TIME_SLOT_REF1", "TIME_SLOT_REF2"},
    "LINGUISTIC_TYPE": {"LINGUISTIC_TYPE_ID"},
    "LANGUAGE": {"LANG_ID"},
    "CONTROLLED_VOCABULARY": {"CV_ID"},
    "CV_ENTRY_ML": {"CVE_ID"},
    "CVE_VALUE": {"LANG_REF"},
}
TIMELINE = Timeline(
    "clip",
    FPS,
    300,
    {
        "brow": [Interval("BrowUp", 10, 40, "left"), Interval("BrowUp", 20, 60, "right")],
        "closure": [],
        "mouth": [Interval("Smile", 1, 7), Interval("SoftSmile", 7, 300)],
    },
)


def document(header="", slots="", tiers=""):
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<ANNOTATION_DOCUMENT AUTHOR="" '
        'DATE="2026-01-01T00:00:00Z" FORMAT="3.0" VERSION="3.0">'
        f'<HEADER MEDIA_FILE="" TIME_UNITS="milliseconds">{header}</HEADER>'
        f"<TIME_ORDER>{slots}</TIME_ORDER>{tiers}</ANNOTATION_DOCUMENT>"
    )


def tier(name, *notes):
    annotations = "".join(
        f'<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="a{n}" TIME_SLOT_REF1="{start}" '
        f'TIME_SLOT_REF2="{end}"><ANNOTATION_VALUE>{value}</ANNOTATION_VALUE>'
        "</ALIGNABLE_ANNOTATION></ANNOTATION>"
        for n, (start, end, value) in enumerate(notes, start=1)
    )
    return f'<TIER LINGUISTIC_TYPE_REF="default-lt" TIER_ID="{name}">{annotations}</TIER>'


SLOTS = "".join(
    f'<TIME_SLOT TIME_SLOT_ID="ts{n}" TIME_VALUE="{time}"/>'
    for n, time in enumerate([0, 400, 400, 2000, 3000], start=1)
)


@pytest.fixture
def file(tmp_path):
    def made(text):
        path = tmp_path / "clip.eaf"
        path.write_text(text, encoding="utf-8")
        return path

    return made


@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_pympi_reads_the_same_intervals(tmp_path_factory, data):
    timeline = data.draw(timelines(data.draw(st.sampled_from(RATES))))
    path = tmp_path_factory.getbasetemp() / "pympi.eaf"
    write(timeline, path)
    eaf = Eaf(str(path))
    found = [
        (name, *note[:3])
        for name in eaf.get_tier_names()
        for note in eaf.get_annotation_data_for_tier(name)
    ]
    assert sorted(found) == sorted(
        (
            f"{interval.track} {interval.side}" if interval.side else interval.track,
            floor(1000 * interval.start / timeline.fps + Fraction(1, 2)),
            floor(1000 * interval.end / timeline.fps + Fraction(1, 2)),
            interval.action,
        )
        for interval in timeline
    )
    assert {name.split()[0] for name in eaf.get_tier_names()} == set(timeline.tracks)
    assert ("mimeline.fps", str(timeline.fps)) in eaf.properties


def test_a_file_that_pympi_saves_again_is_the_same_timeline(tmp_path):
    write(TIMELINE, tmp_path / "a.eaf")
    Eaf(str(tmp_path / "a.eaf")).to_file(str(tmp_path / "b.eaf"))
    assert read(tmp_path / "b.eaf") == TIMELINE


def test_a_file_that_pympi_made_is_read(tmp_path):
    eaf = Eaf()
    for name in ("brow", "Mouth", "gaze_h left"):
        eaf.add_tier(name)
    eaf.remove_tier("default")
    eaf.add_annotation("brow", 334, 1335, "BrowUp")
    eaf.add_annotation("brow", 1335, 2002, "BrowDown")
    eaf.add_annotation("Mouth", 0, 10010, "Smile")
    eaf.to_file(str(tmp_path / "clip.eaf"))
    assert read(tmp_path / "clip.eaf", FPS, 300) == Timeline(
        "clip",
        FPS,
        300,
        {
            "brow": [Interval("BrowUp", 10, 40), Interval("BrowDown", 40, 60)],
            "mouth": [Interval("Smile", 0, 300)],
            "gaze_h": [],
        },
    )


def test_elements_stand_in_the_schemas_order_with_what_it_needs(tmp_path):
    write(TIMELINE, tmp_path / "a.eaf", media=tmp_path / "a.mp4")
    for element in ET.parse(tmp_path / "a.eaf").iter():
        assert NEEDED.get(element.tag, set()) <= set(element.attrib), element.tag
        children = [child.tag for child in element]
        if element.tag in ORDER:
            places = [ORDER[element.tag].index(child) for child in children]
            assert places == sorted(places)
        if element.tag == "TIME_ORDER":
            times = [int(slot.get("TIME_VALUE")) for slot in element]
            assert times == sorted(times)


def test_every_reference_has_what_it_refers_to(tmp_path):
    write(TIMELINE, tmp_path / "a.eaf")
    root = ET.parse(tmp_path / "a.eaf").getroot()
    ids = {
        kind: {e.get(kind) for e in root.iter() if e.get(kind)}
        for kind in ("TIME_SLOT_ID", "LINGUISTIC_TYPE_ID", "CV_ID", "LANG_ID", "CVE_ID")
    }
    for reference, kind in [
        ("TIME_SLOT_REF1", "TIME_SLOT_ID"),
        ("TIME_SLOT_REF2", "TIME_SLOT_ID"),
        ("LINGUISTIC_TYPE_REF", "LINGUISTIC_TYPE_ID"),
        ("CONTROLLED_VOCABULARY_REF", "CV_ID"),
        ("LANG_REF", "LANG_ID"),
        ("CVE_REF", "CVE_ID"),
    ]:
        used = {e.get(reference) for e in root.iter() if e.get(reference)}
        assert used and used <= ids[kind]
    notes = [e.get("ANNOTATION_ID") for e in root.iter("ALIGNABLE_ANNOTATION")]
    assert len(set(notes)) == len(notes) == 4


def test_every_track_has_its_vocabulary_so_that_a_person_may_add_it(tmp_path):
    write(Timeline("a", FPS, 9, {}), tmp_path / "a.eaf")
    eaf = Eaf(str(tmp_path / "a.eaf"))
    assert {
        track: [values[0][0] for values, _ in eaf.controlled_vocabularies[track][1].values()]
        for track in TRACKS
    } == {track: list(track_actions(track)) for track in TRACKS}


def test_the_film_opens_beside_it(tmp_path):
    film = tmp_path / "films" / "my clip.mp4"
    assert "media" not in write(TIMELINE, tmp_path / "out" / "a.eaf", media=film)
    (media,) = ET.parse(tmp_path / "out" / "a.eaf").iter("MEDIA_DESCRIPTOR")
    assert media.get("MEDIA_URL") == f"file://{film.as_posix()}"  # ELAN escapes nothing
    assert media.get("RELATIVE_MEDIA_URL") == "../films/my clip.mp4"
    assert media.get("MIME_TYPE") == "video/mp4"
    assert write(TIMELINE, tmp_path / "a.vtt", media=film)[-1] == "media"


def test_a_foreign_file_needs_its_rate_and_length_said(file):
    path = file(document(slots=SLOTS, tiers=tier("brow", ("ts1", "ts2", "BrowUp"))))
    with pytest.raises(BadFile, match="no frame rate.*--fps RATE"):
        read(path)
    with pytest.raises(BadFile, match="no length.*--frames N"):
        read(path, Fraction(25))
    assert read(path, Fraction(25), 75).tracks == {"brow": (Interval("BrowUp", 0, 10),)}


def test_what_the_file_tells_and_the_user_says_must_agree(tmp_path):
    write(TIMELINE, tmp_path / "a.eaf")
    assert read(tmp_path / "a.eaf", FPS, 300) == TIMELINE
    with pytest.raises(BadFile, match="found 30000/1001 frames per second, expected 25"):
        read(tmp_path / "a.eaf", Fraction(25))
    with pytest.raises(BadFile, match="found 300 frames, expected 299"):
        read(tmp_path / "a.eaf", n_frames=299)


def test_edges_that_were_dragged_go_to_the_nearest_frame_and_lint_says_how_far(file):
    slots = SLOTS.replace('"400"', '"415"')
    path = file(document(slots=slots, tiers=tier("brow", ("ts1", "ts2", "BrowUp"))))
    assert read(path, Fraction(25), 75).tracks["brow"] == (Interval("BrowUp", 0, 10),)
    (problem,) = lint(path, Fraction(25), 75)
    assert problem.severity == "warning" and "15.0 ms from a frame's start" in problem.found
    assert problem.place == "tier brow, annotation a1"


def test_tiers_of_something_else_are_left_out_with_a_warning(file, caplog):
    tiers = tier("speech", ("ts1", "ts4", "hello")) + tier("lid", ("ts1", "ts2", "EyeSquint"))
    path = file(document(slots=SLOTS, tiers=tiers + tier("notes")))
    assert list(read(path, Fraction(25), 75).tracks) == ["lid"]
    assert 'tier "speech": found 1 annotation of something else' in caplog.text
    (problem,) = lint(path, Fraction(25), 75)
    assert problem.severity == "warning"


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("brwo", "BrowUp", 'track "brwo".*Did you mean brow'),
        ("eyebrows", "BrowUp", 'track "eyebrows"'),
        ("Person A", "BrowUp", 'track "Person A"'),
        ("brow", "BrwUp", 'action "BrwUp".*Did you mean BrowUp'),
        ("brow", "", "no action"),
        ("brow", "Smile", "Smile on brow.*Move it to mouth"),
    ],
)
def test_names_that_are_wrong_are_never_left_out_silently(file, name, value, told):
    path = file(document(slots=SLOTS, tiers=tier(name, ("ts1", "ts2", value))))
    with pytest.raises(BadFile, match=told):
        read(path, Fraction(25), 75)


def test_neutral_may_be_written_out(file):
    path = file(document(slots=SLOTS, tiers=tier("brow", ("ts1", "ts4", "Neutral"))))
    assert read(path, Fraction(25), 75).tracks == {"brow": ()}


def test_an_annotation_without_a_time_is_refused(file):
    slots = SLOTS + '<TIME_SLOT TIME_SLOT_ID="ts9"/>'
    path = file(document(slots=slots, tiers=tier("brow", ("ts1", "ts9", "BrowUp"))))
    with pytest.raises(BadFile, match='annotation a1: found time slot "ts9" without a time'):
        read(path, Fraction(25), 75)
    path = file(document(slots=SLOTS, tiers=tier("brow", ("ts1", "ts77", "BrowUp"))))
    with pytest.raises(BadFile, match='"ts77" that is not in the file'):
        read(path, Fraction(25), 75)


def test_annotations_that_hang_on_others_are_refused_on_our_tiers_and_ignored_elsewhere(file):
    note = (
        '<ANNOTATION><REF_ANNOTATION ANNOTATION_ID="r1" ANNOTATION_REF="a1">'
        "<ANNOTATION_VALUE>{}</ANNOTATION_VALUE></REF_ANNOTATION></ANNOTATION></TIER>"
    )
    brow = tier("brow", ("ts1", "ts2", "BrowUp"))
    gloss = tier("gloss").replace("</TIER>", note.format("sure"))
    path = file(document(slots=SLOTS, tiers=brow + gloss))
    assert list(read(path, Fraction(25), 75).tracks) == ["brow"]
    mouth = tier("mouth").replace("</TIER>", note.format("Smile"))
    with pytest.raises(BadFile, match="tier mouth, annotation r1.*hangs on another"):
        read(file(document(slots=SLOTS, tiers=brow + mouth)), Fraction(25), 75)


def test_several_slots_of_one_time_are_one_time(file):
    tiers = tier("brow", ("ts1", "ts2", "BrowUp"), ("ts3", "ts4", "BrowDown"))
    path = file(document(slots=SLOTS, tiers=tiers))
    assert lint(path, Fraction(25), 75) == []
    brow = read(path, Fraction(25), 75).tracks["brow"]
    assert brow == (Interval("BrowUp", 0, 10), Interval("BrowDown", 10, 50))


def test_media_that_are_moved_are_warned_of(file):
    header = (
        '<MEDIA_DESCRIPTOR MEDIA_URL="file:///a.mp4" MIME_TYPE="video/mp4" TIME_ORIGIN="1200"/>'
    )
    path = file(document(header, SLOTS, tier("brow", ("ts1", "ts2", "BrowUp"))))
    (problem,) = lint(path, Fraction(25), 75)
    assert 'moved by "1200" ms' in problem.found and problem.severity == "warning"


@pytest.mark.parametrize(
    ("header", "told"),
    [
        ('<PROPERTY NAME="mimeline.fps">fast</PROPERTY>', "fast.*is no frame rate"),
        ('<PROPERTY NAME="mimeline.fps">30/0</PROPERTY>', "is no frame rate"),
        ('<PROPERTY NAME="mimeline.frames">-3</PROPERTY>', "is no number of frames"),
        ('<PROPERTY NAME="mimeline.frames"/>', "is no number of frames"),
    ],
)
def test_properties_that_were_spoilt_are_refused(file, header, told):
    with pytest.raises(BadFile, match=told):
        read(file(document(header)), Fraction(25), 75)


def test_times_in_frames_of_old_files_are_refused(file):
    path = file(document().replace("milliseconds", "PAL-frames"))
    with pytest.raises(BadFile, match='times in "PAL-frames", expected milliseconds'):
        read(path, Fraction(25), 75)
