import logging

import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.description.describe import describe
from mimeline.config import validate
from mimeline.errors import BadFile

KEYS = validate({})["describe"]


def clip(clip_id, actions=(), emotions=(), attributes=(), **facts):
    """A clip of nine seconds. actions, emotions: (name, start_s, end_s, uncertainty_s)."""
    timed = ("name", "start_s", "end_s", "uncertainty_s")
    row = dict.fromkeys(tables.CLIPS.schema.names) | {
        "clip_id": clip_id,
        "source_id": clip_id,
        "start_s": 100.0,
        "end_s": 109.0,
        "fps_num": 30,
        "fps_den": 1,
        "actions": [dict(zip(timed, action, strict=True)) for action in actions],
        "emotions": [dict(zip(timed, emotion, strict=True)) for emotion in emotions],
        "attributes": list(attributes),
        "texts": [],
        "shard": 0,
    }
    return row | facts


def interval(clip_id, track, action, start_frame, end_frame):
    row = dict.fromkeys(tables.INTERVALS.schema.names)
    known = {"clip_id": clip_id, "track": track, "action": action, "source": "threshold"}
    return row | known | {"start_frame": start_frame, "end_frame": end_frame}


CLIPS = [
    clip(
        "talks",
        [("talk", 0, 5, 1.0), ("smile", 4, 9, 1.0)],
        attributes=["female", "young", "eyeglasses", "lighting:dark"],
    ),
    clip("acts", emotions=[("angry", 0, 9, 0.0)], attributes=["male", "intensity:strong"]),
    clip("untimed", [("nod", 0, 9, None)], emotion="happy", attributes=["male"]),
    clip("silent"),
    clip("own", [("juggles_balls", 0, 9, 0.0)]),
]
INTERVALS = [
    interval("talks", "gaze_h", "GazeLeft", 0, 120),
    interval("talks", "closure", "EyeClose", 60, 66),
    interval("silent", "head_v", "HeadUp", 90, 270),
]


@pytest.fixture
def described(tmp_path):
    """Runs the stage on clips and intervals; gives its three tables."""

    def run(clips, intervals=(), **keys):
        columns = tables.INTERVALS.schema.names
        inputs = tmp_path / "clips.parquet", tmp_path / "intervals.parquet"
        rows = pd.DataFrame(clips, columns=tables.CLIPS.schema.names)
        tables.write(tables.CLIPS, rows, inputs[0])
        tables.write(tables.INTERVALS, pd.DataFrame(intervals, columns=columns), inputs[1])
        names = ("descriptions", "attributes", "weights")
        outputs = {name: tmp_path / f"{name}.parquet" for name in names}
        describe([inputs[0]], [inputs[1]], **outputs, **(KEYS | keys))
        schemas = (tables.DESCRIPTIONS, tables.ATTRIBUTES, tables.WEIGHTS)
        return [
            tables.read(schema, outputs[name]) for schema, name in zip(schemas, names, strict=True)
        ]

    return run


def by_clip(descriptions):
    return {key: list(rows) for key, rows in descriptions.groupby(["clip_id", "source"])["text"]}


def test_what_a_clip_shows_is_told_from_its_catalogue_and_from_its_timeline(described):
    texts = by_clip(described(CLIPS, INTERVALS)[0])
    assert texts["talks", "catalogue"][0] == (
        "To begin with, the woman talks for some time, then she talks and smiles for a short time, "
        "in the end she smiles for some time."
    )
    assert texts["talks", "timeline"][0] == "The woman looks to her left for some time, blinking."
    assert texts["acts", "catalogue"][0] == "The man looks very angry the whole time."
    assert texts["untimed", "catalogue"][0] == "The man nods and looks happy."
    assert (
        texts["silent", "timeline"][0]
        == "After a while, the person keeps their head up for a long time."
    )
    assert ("silent", "catalogue") not in texts and ("acts", "timeline") not in texts


def test_looks_are_told_in_some_texts_and_only_where_they_are_known(described):
    texts = by_clip(described(CLIPS, INTERVALS, texts=30)[0])
    assert len(texts["talks", "catalogue"]) == 30
    young = [text for text in texts["talks", "catalogue"] if "young woman with glasses" in text]
    assert 0 < len(young) < 30
    assert not any("glasses" in text for text in texts["acts", "catalogue"])
    assert not any("dark" in text for text in texts["talks", "catalogue"])


def test_texts_are_the_same_whatever_other_clips_there_are(described):
    alone = described(CLIPS[:1], INTERVALS)[0]
    among = described(CLIPS[::-1], INTERVALS[::-1])[0]
    among = among[among["clip_id"] == "talks"].reset_index(drop=True)
    pd.testing.assert_frame_equal(alone, among)


def test_another_seed_chooses_other_words(described):
    one, other = (by_clip(described(CLIPS, seed=seed)[0]) for seed in (0, 1))
    assert one["talks", "catalogue"][0] == other["talks", "catalogue"][0]
    assert one["talks", "catalogue"][1:] != other["talks", "catalogue"][1:]


def test_what_is_shown_is_counted(described):
    table = described(CLIPS, INTERVALS)[1].set_index(["kind", "attribute"])
    assert table.loc[("action", "talk")].tolist() == [1, 0.2, 5.0]
    assert table.loc[("timeline", "GazeLeft")].tolist() == [1, 0.2, 4.0]
    assert table.loc[("emotion", "angry"), "seconds"] == 9.0
    assert table.loc[("attribute", "male"), "clips"] == 2
    assert table.loc[("action", "nod")].isna()["seconds"]  # nobody says when


def test_every_clip_has_a_weight(described):
    weights = described(CLIPS, INTERVALS, balance=1.0)[2]
    assert list(weights["clip_id"]) == sorted(row["clip_id"] for row in CLIPS)
    assert weights["weight"].mean() == pytest.approx(1)


def test_names_without_a_template_are_told_once(described, caplog):
    clips = [clip(f"c{n}", [("juggles_balls", 0, 9, 0.0)]) for n in range(5)]
    with caplog.at_level(logging.WARNING, logger="mimeline"):
        texts = described(clips)[0]["text"]
    assert texts[0] == "The person juggles balls the whole time."
    (warning,) = [record.getMessage() for record in caplog.records]
    assert "juggles_balls as 'juggles balls'" in warning


def test_the_length_is_that_of_the_frames_where_they_are_known(described):
    cut = clip("cut", [("smile", 0, 4, 0.0)], n_frames=120)
    assert described([cut])[0]["text"][0] == "The person smiles the whole time."


def test_what_nobody_timed_stays_so_where_the_film_is_a_frame_longer(described):
    longer = clip("longer", [("nod", 0, 9, None)], n_frames=271)
    assert described([longer])[0]["text"][0] == "The person nods."


def test_a_timeline_without_a_frame_rate_is_not_told(described):
    unclocked = clip("talks", fps_num=None, fps_den=None)
    assert described([unclocked], INTERVALS)[0].empty


def test_no_clip_and_nothing_to_tell_give_empty_tables_with_a_reason(described, tmp_path):
    assert all(table.empty for table in described([]))
    descriptions, attributes, weights = described([clip("silent")])
    assert descriptions.empty and attributes.empty and len(weights) == 1
    assert "no clip has an action" in tables.reason(tmp_path / "descriptions.parquet")


def test_a_name_of_a_template_in_other_letters_is_that_template(described):
    texts = described([clip("c", [("Shake head", 0, 9, 0.0)])])[0]["text"]
    assert texts[0] == "The person shakes their head the whole time."


def test_own_templates_are_used_and_their_mistakes_told(described, tmp_path):
    mine = tmp_path / "mine.yaml"
    mine.write_text("actions: {talk: [chats, chat, chatting]}", encoding="utf-8")
    texts = by_clip(described(CLIPS, templates=str(mine))[0])
    assert "the woman chats" in texts["talks", "catalogue"][0]
    mine.write_text("actoins: {}", encoding="utf-8")
    with pytest.raises(BadFile, match="actoins"):
        described(CLIPS, templates=str(mine))
