import re
from pathlib import Path

import pytest
import yaml

from mimeline.clips.description.templates import Templates, fill, read_templates
from mimeline.errors import BadFile
from mimeline.vocabulary import ACTIONS, resource
from mimeline.workflow import _parsed


def own(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_first_wordings_are_those_of_the_thesis():
    templates = read_templates()
    assert templates.openers.first[0] == "to begin with,"
    assert templates.openers.next[0] == "then"
    assert templates.openers.last[0] == "in the end"


def test_the_wording_knows_every_action_of_our_timelines():
    assert set(ACTIONS) <= set(read_templates().actions)


def test_the_file_is_packed_with_the_package():
    assert resource("descriptions.yaml").is_file()


def test_a_file_of_ones_own_changes_only_what_it_names(tmp_path):
    path = own(
        tmp_path,
        "openers: {next: [und dann]}\n"
        "actions:\n  juggle: [juggles, juggle, juggling]\n"
        "  EyeClose: {brief_s: 0.3}\n",
    )
    templates, product = read_templates(path), read_templates()
    assert templates.openers.next == ["und dann"]
    assert templates.openers.first == product.openers.first
    assert templates.actions["juggle"].throughout == ["juggles", "juggle", "juggling"]
    assert templates.actions["EyeClose"].brief_s == 0.3
    assert templates.actions["EyeClose"].brief == product.actions["EyeClose"].brief
    assert templates.actions["talk"] == product.actions["talk"]


def test_an_empty_file_changes_nothing(tmp_path):
    assert read_templates(own(tmp_path, "")) == read_templates()


@pytest.mark.parametrize(
    ("text", "place", "found"),
    [
        ("greetings: [hello]", "mine.yaml", "the key greetings"),
        ("openers: {middle: [then]}", "openers", "the key middle"),
        ("mentions: ['the {name}']", "mentions.0", "the {name}"),
        ("mentions: ['the {noun.__class__}']", "mentions.0", "noun.__class__"),
        ("mentions: ['the {noun']", "mentions.0", "the {noun"),
        ("mentions: ['the {}']", "mentions.0", "the {}"),
        ("actions: {talk: [talks, talk]}", "actions.talk.throughout", "talks"),
        ("actions: {talk: talks}", "actions.talk", "talks"),
        ("actions: {talk: ['{verb}', a, b]}", "actions.talk.throughout.0", "{verb}"),
        ("subjects: {female: {plural: perhaps}}", "subjects.female.plural", "perhaps"),
        ("durations: [{up_to: 0.5, says: [briefly]}]", "mine.yaml", "durations"),
        ("openers: {next: []}", "openers.next", "[]"),
        ('openers: {next: ["then\\e[31m"]}', "openers.next.0", "then"),
        ("- a\n- b", "mine.yaml", "list"),
        ("a: [", "mine.yaml", "expected"),
        ("1: 2", "mine.yaml", "1"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, text, place, found):
    with pytest.raises(BadFile) as error:
        read_templates(own(tmp_path, text))
    assert "mine.yaml" in error.value.file
    assert place in str(error.value)
    assert found in str(error.value)
    assert "docs/descriptions.md" in str(error.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("actions: {talk: [talks, talk]}", "expected 3 entries or more"),
        ("actions: {talk: [a, b, c, d]}", "expected 3 entries at most"),
        ("subjects: {female: {plural: perhaps}}", "expected true or false"),
        ("openers: {next: [1]}", "expected a text"),
        ("durations: [{up_to: 2, says: [briefly]}]", "expected less than or equal to 1"),
        ("mentions: ['the {name}']", "expected a text whose slots are among: {a}, {noun}"),
        ("joins: [{last: and}]", "found nothing, expected this key"),
    ],
)
def test_what_was_expected_is_said_in_plain_words(tmp_path, text, expected):
    with pytest.raises(BadFile) as error:
        read_templates(own(tmp_path, text))
    assert expected in str(error.value)


def test_a_file_that_is_not_there_or_no_text_is_told(tmp_path):
    with pytest.raises(BadFile, match="no such file"):
        read_templates(tmp_path / "none.yaml")
    (tmp_path / "mine.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadFile):
        read_templates(tmp_path / "mine.yaml")


def test_objects_of_yaml_are_refused(tmp_path):
    path = own(tmp_path, "mentions: !!python/object/apply:os.system ['true']")
    with pytest.raises(BadFile):
        read_templates(path)


def test_what_is_put_in_a_slot_is_not_filled_again():
    assert fill("{a} {noun}", a="{noun}", noun="x") == "{noun} x"


def test_no_key_of_the_wording_stands_twice():
    """YAML keeps the last of two, without a word."""
    node = yaml.compose(resource("descriptions.yaml").read_text(encoding="utf-8"))
    todo = [node]
    while todo:
        node = todo.pop()
        if isinstance(node, yaml.MappingNode):
            keys = [key.value for key, _ in node.value]
            assert len(keys) == len(set(keys))
            todo += [value for _, value in node.value]


def test_the_examples_of_the_documentation_are_good_templates(tmp_path):
    page = (Path(__file__).parents[3] / "docs" / "descriptions.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    templates = read_templates(own(tmp_path, example))
    assert templates.actions["juggle"].throughout[0] == "juggles"


def test_the_documentation_names_every_key():
    page = (Path(__file__).parents[3] / "docs" / "descriptions.md").read_text(encoding="utf-8")
    assert [key for key in Templates.model_fields if f"`{key}`" not in page] == []


def test_changed_wording_reruns_the_stage_that_reads_it(monkeypatch):
    """The digest of the stage's code knows the file."""
    read = []
    bytes_of = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read.append(path.name) or bytes_of(path))
    _parsed.__wrapped__("mimeline.clips.description.templates")
    assert "descriptions.yaml" in read
