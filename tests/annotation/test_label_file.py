import subprocess

import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from mimeline.annotation.label_file import (
    MOST_CHARACTERS,
    Answer,
    RegionAnswers,
    read_label_file,
    root,
    write_label_file,
)
from mimeline.annotation.plain_yaml import MOST_BYTES
from mimeline.errors import BadLabels

QUICK = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

notes = st.text(min_size=1, max_size=MOST_CHARACTERS).filter(str.isprintable)
words = st.text(min_size=1, max_size=20)
names = st.sampled_from(["BrowUp", "Neutral", "Smile"])
clip_ids = st.one_of(
    words, st.sampled_from(["007", "1e3", "no", "null", "~", "12:30:45", "é😀", "a: b"])
)
answers = st.one_of(st.builds(Answer, names, st.none() | notes), st.just(Answer()))
intervals = st.tuples(clip_ids, st.integers(0, 9999), st.integers(10_000, 20_000))
regions = st.builds(
    RegionAnswers,
    st.from_regex(r"[0-9a-f]{16}", fullmatch=True),
    st.dictionaries(st.integers(0, 40), answers, max_size=6),
    st.dictionaries(
        st.integers(0, 40), st.lists(intervals, min_size=1, max_size=3).map(tuple), max_size=4
    ),
    st.frozensets(st.integers(41, 60), max_size=3),
)
files = st.dictionaries(st.sampled_from(["brow", "eye", "mouth"]), regions, max_size=3)

SOUND = {
    "brow": RegionAnswers(
        "3f2a90c1d2e4b5a6",
        {0: Answer("BrowUp", "strong"), 1: Answer("Neutral"), 2: Answer(same_as=0), 3: Answer()},
        {0: (("clip_12", 34, 61), ("clip_3", 0, 25))},
        frozenset({4}),
    )
}


@pytest.fixture
def read(tmp_path):
    def read(content):
        path = tmp_path / "mine.yaml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_label_file(path)

    return read


def complaint(read, content) -> str:
    """What is said of a file that is refused: its name, in one line of text that can be printed."""
    with pytest.raises(BadLabels) as caught:
        read(content)
    error = caught.value
    assert "mine.yaml" in str(error)
    assert str(error).isprintable()
    assert error.found and error.expected and error.remedy
    return str(error)


@settings(QUICK, max_examples=50)
@given(files)
def test_what_is_written_is_read_and_written_again_the_same(tmp_path, content):
    path = tmp_path / "mine.yaml"
    write_label_file(path, content)
    first = path.read_bytes()
    assert read_label_file(path) == content
    write_label_file(path, read_label_file(path))
    assert path.read_bytes() == first


def test_each_cluster_has_a_line_of_its_own(tmp_path):
    path = tmp_path / "mine.yaml"
    write_label_file(path, SOUND)
    lines = path.read_text().split("\n")
    for line in ("    0: {action: BrowUp, note: strong}", "    2: {same_as: 0}", "    3: not sure"):
        assert line in lines
    assert "    0: [[clip_12, 34, 61], [clip_3, 0, 25]]" in lines


def test_names_in_other_scripts_stay_readable(tmp_path):
    write_label_file(
        tmp_path / "mine.yaml", {"brow": RegionAnswers("a", {0: Answer("BrowUp", "fröhlich 高")})}
    )
    assert "note: fröhlich 高" in (tmp_path / "mine.yaml").read_text(encoding="utf-8")


@QUICK
@given(st.text(max_size=300))
@example("brow: {model: a, clusters: {0: " + "[" * 5000)
@example("<<: {a: b}")
@example("? [a]\n: b")
@example("brow: {model: a, clusters: {0: !!timestamp x}}")
def test_any_text_is_a_label_file_or_refused_in_one_line(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        read_label_file(path)
    except BadLabels as error:
        assert str(error).isprintable()


@QUICK
@given(st.data())
def test_a_sound_file_with_bytes_changed_is_read_or_refused_in_one_line(tmp_path, data):
    path = tmp_path / "mine.yaml"
    write_label_file(path, SOUND)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        kind = data.draw(st.sampled_from(["change", "drop", "add"]))
        piece = data.draw(
            st.binary(min_size=1, max_size=1)
            | st.sampled_from(list(b":{}[],&*!-\n \t0")).map(lambda c: bytes([c]))
        )
        content[at : at + (kind != "add")] = b"" if kind == "drop" else piece
    path.write_bytes(bytes(content))
    try:
        read_label_file(path)
    except BadLabels as error:
        assert str(error).isprintable()


@QUICK
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | names,
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(
                    [
                        "brow",
                        "model",
                        "clusters",
                        "shown",
                        "same_as",
                        "action",
                        "note",
                        0,
                        1,
                        -1,
                        True,
                    ]
                ),
                inner,
                max_size=4,
            )
        ),
        max_leaves=12,
    )
)
def test_any_yaml_is_a_label_file_or_refused_in_one_line(tmp_path, value):
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(value), encoding="utf-8")
    try:
        for own in read_label_file(path).values():
            assert all(type(number) is int and number >= 0 for number in own.clusters)
    except BadLabels as error:
        assert str(error).isprintable()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("brow: [", "line 1: .*expected YAML"),
        ("brow: {model: \x07}", r"line 1: found the character U\+0007"),
        (b"brow:\n  model: \xff\n", "line 2: found the byte 0xff, expected YAML in UTF-8"),
        ("- brow\n- eye\n", "expected regions"),
        ("BrowUp", "found 'BrowUp', expected regions"),
        ("brow: BrowUp", "region brow: found 'BrowUp'"),
        ("brow:", "region brow: found nothing"),
        ("brow: {}", "region brow: found {}, expected the keys model and clusters"),
        ("brow:\n  0: BrowUp", "found the keys 0, expected the keys model and clusters"),
        ("brow: {model: x, clusters: {}, seen: {}}", "found the keys model, clusters, seen"),
        ("brow: {model: x, clusters: [BrowUp]}", "clusters by their numbers"),
        ("brow: {model: ../../x, clusters: {}}", "region brow, model: found '../../x'"),
        ("brow: {model: [x], clusters: {}}", "region brow, model"),
        ("brow: {model: x, clusters: {0: BrowUp, 1: Neutral, 0: Neutral}}", "key 0 a second time"),
        ("eye: {model: x, clusters: {}}\neye: {model: y, clusters: {}}", "line 2: .*key eye"),
        ("brow: !!map [BrowUp]", "found the tag"),
        ("!!python/object/apply:os.getcwd []", "found the tag"),
        ("brow: &a {model: x, clusters: {}}\neye: *a", "found an anchor or alias"),
        ("a: 1\n---\nb: 2", "expected YAML"),
        ("brow: " + "[" * 20 + "]" * 20, "nested too deep"),
        ("<<<<<<< HEAD\nbrow:\n=======\neye:\n>>>>>>> theirs\n", "line 1: found marks"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_label_file_is_refused_with_its_place(read, text, message):
    with pytest.raises(BadLabels, match=message):
        read(text)
    complaint(read, text)


@pytest.mark.parametrize(
    "number", ["-1", "1.0", ".nan", "true", "brow", "00", "0x1", "1_0", "~", '""', "9" * 40]
)
def test_a_cluster_whose_key_is_no_number_is_refused(read, number):
    assert "region brow, clusters" in complaint(
        read, f"brow: {{model: x, clusters: {{{number}: BrowUp}}}}"
    )


@pytest.mark.parametrize(
    "name",
    [
        "~",
        '""',
        "[BrowUp]",
        "{note: strong}",
        "{action: ~}",
        "{action: BrowUp, notes: x}",
        "{}",
        "{same_as: x}",
        "{same_as: -1}",
        "{same_as: true}",
        "{same_as: 1, note: x}",
    ],
)
def test_an_answer_that_says_nothing_is_refused(read, name):
    said = complaint(read, f"brow: {{model: x, clusters: {{2: {name}}}}}")
    assert "region brow, cluster 2" in said


@pytest.mark.parametrize("note", ['"a\\nb"', '"\\x07"', '"\\u202e"', "[a]", "a" * 201])
def test_a_note_is_one_line_of_bounded_length(read, note):
    said = complaint(read, f"brow: {{model: x, clusters: {{2: {{action: BrowUp, note: {note}}}}}}}")
    assert "expected one line of at most 200 characters" in said


def test_a_note_needs_an_action(read):
    assert "beside an action" in complaint(
        read, "brow: {model: x, clusters: {2: {action: not sure, note: strange}}}"
    )


def test_clusters_that_are_the_same_in_a_circle_are_refused(read):
    said = complaint(
        read, "brow: {model: x, clusters: {0: {same_as: 1}, 1: {same_as: 2}, 2: {same_as: 0}}}"
    )
    assert "cluster 0, which is the same as 1, which is the same as 2" in said
    assert "region brow, cluster 3" in complaint(
        read, "brow: {model: x, clusters: {3: {same_as: 3}}}"
    )


def test_a_merged_cluster_ends_in_its_root(read):
    own = read("brow: {model: x, clusters: {0: {same_as: 1}, 1: {same_as: 2}, 2: BrowUp}}")["brow"]
    assert [root(own.clusters, n) for n in (0, 1, 2, 7)] == [2, 2, 2, 7]


@pytest.mark.parametrize(
    "rows", ["[a, 0, 5]", "[[a, 5, 5]]", "[[a, -1, 5]]", "[[a, 0]]", "[[a, 0, 1.5]]",
     "[[[a], 0, 5]]", "x", "[['', 0, 5]]", "{a: 1}"],
)  # fmt: skip
def test_an_interval_that_is_none_is_refused(read, rows):
    said = complaint(read, f"brow: {{model: x, clusters: {{}}, shown: {{4: {rows}}}}}")
    assert "region brow, shown, cluster 4" in said


def test_a_file_that_is_too_large_is_refused_before_it_is_parsed(read):
    assert "bytes" in complaint(read, b"#" * (MOST_BYTES + 1))


def test_a_file_by_hand_needs_only_model_and_clusters(read):
    text = """
    brow:
      # mine
      model: 0123456789012345
      clusters:
        0: BrowUp
        1: {action: BrowUp, note: 3}
    """
    assert read(text) == {
        "brow": RegionAnswers("0123456789012345", {0: Answer("BrowUp"), 1: Answer("BrowUp", "3")})
    }
    assert read("# nothing yet\n") == {}
    assert read("brow:\n  model: x\n  clusters:\n") == {"brow": RegionAnswers("x")}


@pytest.mark.parametrize("path", ["nowhere.yaml", ".", "no\0where"])
def test_a_label_file_that_is_not_there_names_the_key(path):
    with pytest.raises(BadLabels, match="label.file"):
        read_label_file(path)


def merged(tmp_path, ours: dict, theirs: dict, base: dict) -> tuple[int, str]:
    """What git makes of two persons' changes of one file: its status and the text."""
    for name, content in (("base", base), ("ours", ours), ("theirs", theirs)):
        write_label_file(tmp_path / name, content)
    done = subprocess.run(
        ["git", "merge-file", "-p", "ours", "base", "theirs"],
        cwd=tmp_path,
        capture_output=True,
        encoding="utf-8",
    )
    return done.returncode, done.stdout


def brow(**changes) -> dict:
    names = dict.fromkeys(range(4), Answer("Neutral")) | {int(k[1:]): v for k, v in changes.items()}
    return {"brow": RegionAnswers("a", names, {0: (("clip", 0, 9),)}), "eye": RegionAnswers("b")}


@pytest.mark.parametrize("one", range(4))
@pytest.mark.parametrize("other", range(4))
def test_changes_of_different_clusters_merge_in_git(tmp_path, read, one, other):
    ours, theirs = {f"_{one}": Answer("BrowUp")}, {f"_{other}": Answer("BrowDown", "weak")}
    status, text = merged(tmp_path, brow(**ours), brow(**theirs), brow())
    if one != other:
        assert (status, read(text)) == (0, brow(**ours, **theirs))
    else:
        assert status == 1
        assert "marks of a conflict in git" in complaint(read, text)
