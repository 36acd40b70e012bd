import pytest

from mimeline.clips.exclusions import REASONS, read_exclusions, write_exclusions
from mimeline.errors import BadFile, MissingColumn


@pytest.fixture
def listed(tmp_path):
    """Reads what a file of these bytes lists."""

    def listed(content: str | bytes) -> dict[str, str]:
        path = tmp_path / "exclusions.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_exclusions(path)

    return listed


def test_a_list_is_read_as_it_was_written_whatever_the_reasons_hold(tmp_path):
    exclusions = {
        "-b_0": 'a "mask", or so',
        "a": "occlusion; glasses",
        "c#2": "unscharf ß",
        "d": "",
    }
    write_exclusions(tmp_path / "deep" / "list.csv", exclusions)
    assert read_exclusions(tmp_path / "deep" / "list.csv") == exclusions


def test_a_written_list_is_sorted_and_leaves_nothing_beside_it(tmp_path):
    path = tmp_path / "list.csv"
    write_exclusions(path, {"b": REASONS[0], "a": REASONS[1]})
    write_exclusions(path, {"b": REASONS[0], "a": REASONS[1], "B": REASONS[2]})
    assert path.read_text() == ("clip_id,reason\nB,low_quality\na,wrong_crop\nb,occlusion\n")
    assert [file.name for file in tmp_path.iterdir()] == ["list.csv"]


def test_a_list_that_cannot_be_written_leaves_the_old_one(tmp_path):
    path = tmp_path / "list.csv"
    write_exclusions(path, {"a": "mask"})
    with pytest.raises(UnicodeEncodeError):
        write_exclusions(path, {"a": "mask", "b": "\ud800"})
    assert read_exclusions(path) == {"a": "mask"}
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    "content",
    [
        "\ufeffclip_id,reason\r\na,mask\r\nb,\r\n",
        "clip_id;reason\na;mask\nb;\n",
        "clip_id\treason\na\tmask\nb\n",
        " clip_id , reason \n\n a , mask\nb,\n,\n",
        "who,reason,clip_id\nme,mask,a\nyou,,b\n",
    ],
)
def test_what_spreadsheets_make_of_a_list_is_read_alike(listed, content):
    assert listed(content) == {"a": "mask", "b": ""}


def test_the_reasons_of_an_id_that_occurs_twice_are_joined(listed):
    assert listed("clip_id,reason\na,mask\na,blurred\na,mask\na,\n") == {"a": "mask; blurred"}


def test_a_reason_in_two_lines_is_told_in_one(listed):
    assert listed('clip_id,reason\na,"a mask,\nand glasses"\n') == {"a": "a mask, and glasses"}


@pytest.mark.parametrize(
    ("content", "error", "told"),
    [
        ("", MissingColumn, "an empty file"),
        ("clip\na\n", MissingColumn, "expected clip_id, reason"),
        ("a,mask\n", MissingColumn, "found columns a, mask"),
        ("clip_id,reason\na,mask, and more\n", BadFile, "line 2: found 3 cells"),
        ("clip_id,reason\nb,x\n,mask\n", BadFile, "line 3: found a reason without a clip_id"),
        ('clip_id,reason\na,"mask\n', BadFile, "line 2: found unexpected end.*quotation marks"),
        (b"clip_id,reason\na,\xff\xfe\n", BadFile, "no UTF-8.*Save it as CSV UTF-8"),
    ],
)
def test_a_list_that_is_none_says_what_is_wrong(listed, content, error, told):
    with pytest.raises(error, match=told):
        listed(content)


def test_a_list_that_is_not_there_says_so(tmp_path):
    with pytest.raises(BadFile, match="no such file"):
        read_exclusions(tmp_path / "none.csv")
