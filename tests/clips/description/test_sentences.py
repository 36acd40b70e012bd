import re

import pytest

from mimeline.clips.description.inflection import forms
from mimeline.clips.description.lexicon import Lexicon
from mimeline.clips.description.sentences import Scene, texts_of
from mimeline.clips.description.stretches import Run, Stretch, runs
from mimeline.clips.description.telling import told
from mimeline.clips.description.templates import read_templates
from mimeline.vocabulary import ACTIONS

FIGURE = (
    "To begin with, the woman talks and gazes for a short time, then she talks, gazes and frowns "
    "for a short time, in the end she talks, gazes and blinks for a long time."
)
CELEBV_TEXT = re.findall(
    r"\w+",
    """talk head_wagging look_around turn shake_head nod blink wink squint close_eyes drink sing eat
    smoke listen_to_music play_instrument read kiss whisper sneer sigh frown weep cry smile glare
    gaze laugh shout yawn sneeze cough sleep make_a_face blow sniff chew""",
)
CELEBV_HQ = sorted(set(CELEBV_TEXT) - {"blink", "squint"})
CELEBV_EMOTIONS = ("neutral", "happy", "sad", "anger", "fear", "surprise", "contempt", "disgust")
ACTED_EMOTIONS = ("calm", "angry", "fearful", "surprised", "disgusted")  # RAVDESS and MEAD


@pytest.fixture(scope="module")
def lexicon():
    return Lexicon(read_templates())


def scene(lexicon, actions, duration_s, subject="female", uncertainty_s=0.0, **facts):
    """actions: (name, start_s, end_s)."""
    given = [
        {"name": name, "start_s": start, "end_s": end, "uncertainty_s": uncertainty_s}
        for name, start, end in actions
    ]
    all_runs, rank = runs(given, duration_s), lexicon.rank
    parts = told(
        *(all_runs, duration_s, 1.0, 5, 50, rank),
        n_words=lambda name: lexicon.said(name, subject).n_words,
    )
    noun = getattr(lexicon.templates.subjects, subject).noun
    known = {"nouns": [noun], "untimed": []} | facts
    return Scene(subject, known["nouns"], known["untimed"], parts, duration_s, 1.0)


def plain(lexicon, *args, **facts):
    return texts_of(scene(lexicon, *args, **facts), lexicon, 1, "key")[0]


def test_the_figure_of_the_thesis_comes_out_word_for_word(lexicon):
    actions = [("talk", 0, 11), ("gaze", 0, 11), ("frown", 2, 3), ("blink", 4, 11)]
    assert plain(lexicon, actions, 11.0, uncertainty_s=1.0) == FIGURE
    assert plain(lexicon, actions[::-1], 11.4, uncertainty_s=1.0) == FIGURE


def test_the_figure_comes_out_of_the_published_annotation(lexicon, real_data):
    import json

    samples = json.loads((real_data / "celebv" / "annotation_samples.json").read_text())
    actions = [
        (name, *(60 * int(time.split(":")[1]) + int(time.split(":")[2]) - 547 for time in times))
        for name, (*times, _, _) in samples["records"][1]["act"]
    ]
    assert plain(lexicon, actions, 11.0, uncertainty_s=1.0) == FIGURE


@pytest.mark.parametrize("name", [*CELEBV_TEXT, *CELEBV_HQ, *ACTIONS])
def test_every_known_action_has_forms_that_agree(lexicon, name):
    said = {subject: lexicon.said(name, subject) for subject in ("female", "male", "unknown")}
    assert lexicon.untold == {}
    for subject, their in (("female", "her"), ("male", "his"), ("unknown", "their")):
        for given in (said[subject].throughout, said[subject].passing, said[subject].brief):
            if given is not None:
                one, many, doing = (form.split() for form in given)
                assert one[1:] == many[1:] == doing[1:]
                assert set(one) & {"her", "his", "their"} <= {their}
                assert (one[0], many[0], doing[0]) == forms(many[0])


@pytest.mark.parametrize("emotion", [*CELEBV_EMOTIONS, *ACTED_EMOTIONS])
def test_every_known_emotion_is_a_look(lexicon, emotion):
    text = plain(lexicon, [(lexicon.emotion(emotion), 0, 5)], 5.0, subject="male")
    assert re.fullmatch(r"The man looks \w+ the whole time\.", text)
    assert lexicon.untold == {}


@pytest.mark.parametrize(
    ("subject", "expected"),
    [
        ("female", "To begin with, the woman shakes her head for a long time, then she smiles"),
        ("male", "To begin with, the man shakes his head for a long time, then he smiles"),
        ("unknown", "To begin with, the person shakes their head for a long time, then they smile"),
    ],
)
def test_pronouns_and_verbs_agree(lexicon, subject, expected):
    actions = [("shake_head", 0, 6), ("smile", 6, 10)]
    assert plain(lexicon, actions, 10.0, subject) == f"{expected} for some time."


def test_a_person_named_again_is_one(lexicon):
    actions = [("nod", 0, 4), ("smile", 4, 8), ("nod", 8, 12)]
    found = texts_of(scene(lexicon, actions, 12.0, "unknown"), lexicon, 200, "key")
    assert not any(re.search(r"person (nod|smile)\b", text) for text in found)
    assert not any(re.search(r"they (nods|smiles)\b", text) for text in found)
    assert any("the person smiles" in text for text in found)


def test_left_and_right_are_the_persons_own(lexicon):
    text = plain(lexicon, [("GazeLeft", 0, 5), ("HeadRight", 5, 10)], 10.0, "male")
    assert "he looks to his left" not in text and "the man looks to his left" in text
    assert "keeps his head turned to his right" in text


@pytest.mark.parametrize(
    ("passing", "expected"),
    [
        ([("EyeClose", 3, 3.2)], "blinking"),
        ([("EyeClose", 3, 3.2), ("EyeClose", 5, 5.2)], "blinking twice"),
        ([("EyeClose", n, n + 0.2) for n in (2, 4, 6)], "at times blinking"),
        ([("EyeClose", 3, 3.8)], "briefly closing her eyes"),
        ([("GazeUp", 3, 3.8)], "briefly looking up"),
        ([("GazeUp", 3, 3.8), ("nod", 5, 5.5)], "at times looking up and nodding"),
    ],
)
def test_what_passes_is_told_beside_what_lasts(lexicon, passing, expected):
    text = plain(lexicon, [("smile", 0, 9), *passing], 9.0)
    assert text == f"The woman smiles the whole time, {expected}."


def test_what_passes_alone_is_told_in_full_verbs(lexicon):
    assert plain(lexicon, [("EyeClose", 0, 0.2)], 9.0) == "The woman blinks."
    assert plain(lexicon, [("nod", 0.3, 0.8)], 9.0, "male") == "The man briefly nods."


def test_a_short_time_of_unsure_length_is_not_called_brief(lexicon):
    text = plain(lexicon, [("smile", 0, 9), ("nod", 3, 3.5)], 9.0, uncertainty_s=1.0)
    assert text == "The woman smiles the whole time, at one point nodding."


def test_a_clip_that_starts_or_pauses_with_nothing_says_when(lexicon):
    actions = [("smile", 2, 4), ("nod", 6, 8), ("smile", 8, 9.5)]
    assert plain(lexicon, actions, 12.0) == (
        "After a while, the woman smiles for a short time, a little later, she nods for a short "
        "time, then she smiles for a short time."
    )


def test_what_passes_alone_is_told_when_it_happens(lexicon):
    actions = [("smile", 0, 4), ("nod", 7, 7.5), ("EyeClose", 8.8, 9)]
    assert plain(lexicon, actions[1:2], 12.0) == "After a while, the woman briefly nods."
    assert plain(lexicon, actions, 12.0) == (
        "To begin with, the woman smiles for a short time, a little later, she nods and blinks."
    )


def test_what_goes_on_from_before_does_not_begin_anew(lexicon):
    turns = Run(3.5, 8, "HeadLeft"), Run(8.5, 8.8, "HeadLeft")
    parts = [Stretch(0, 5, ("smile",)), Stretch(5, 9, (), turns)]
    text = texts_of(Scene("female", ["woman"], [], parts, 9.0, 1.0), lexicon, 1, "key")[0]
    assert text.endswith(", then she at times keeps her head turned to her left.")


def test_what_passes_beside_an_emotion_that_lasts_is_told_when_it_happens(lexicon):
    sad = (lexicon.emotion("sad"), 0, 9.5)
    text = plain(lexicon, [sad, ("gaze", 0.9, 3.9), ("nod", 7, 7.5)], 9.5)
    assert text == (
        "The woman looks sad the whole time. To begin with, she gazes for some time, a little "
        "later, she briefly nods."
    )
    text = plain(lexicon, [sad, ("nod", 3, 3.5), ("smile", 5, 9.5)], 9.5)
    assert text.startswith("The woman looks sad the whole time. After a while, she briefly nods,")


def test_the_start_of_a_busy_timeline_is_told(lexicon):
    timeline = """EyeSquint 0-1.7, SoftSmile 0-1.97, GazeRight 0-0.33, HeadDown 0.67-1.03,
        GazeUp 0.83-2.53, HeadLeft 1.67-3.2, BrowUp 2.2-4.27, EyeClose 2.9-3, HeadLeft 3.23-3.33,
        MouthFrown 4.2-6.17, GazeDown 4.33-5.33, EyeSquint 4.8-7.9, HeadLeft 4.93-5.5,
        HeadDown 5.3-6.3, HeadLeft 5.57-7.6, GazeLeft 6.4-8.27, BrowUp 7.07-8.9, GazeUp 7.9-8.9"""
    actions = [
        (name, *map(float, times.split("-"))) for name, times in map(str.split, timeline.split(","))
    ]
    assert plain(lexicon, actions, 8.9).startswith("To begin with, the woman smiles softly")


def test_an_emotion_that_lasts_is_told_once(lexicon):
    happy = lexicon.emotion("happy", "very")
    text = plain(lexicon, [(happy, 0, 9), ("talk", 0, 4), ("smile", 4, 9)], 9.0)
    assert text == (
        "The woman looks very happy the whole time. To begin with, she talks for some time, then "
        "she smiles for a long time."
    )


def test_an_emotion_that_changes_is_part_of_the_stretches(lexicon):
    sad, happy = lexicon.emotion("sad"), lexicon.emotion("happy")
    text = plain(lexicon, [(sad, 0, 4), (happy, 4, 9), ("talk", 0, 9)], 9.0)
    assert text == (
        "To begin with, the woman talks and looks sad for some time, then she talks and looks "
        "happy for a long time."
    )


def test_neutral_is_neither_strong_nor_weak(lexicon):
    assert lexicon.said(lexicon.emotion("neutral", "very"), "male").throughout[0] == "looks neutral"


def test_what_nobody_timed_is_told_without_times(lexicon):
    text = plain(lexicon, [], 9.0, untimed=["talk", "smile", lexicon.emotion("happy")])
    assert text == "The woman talks, smiles and looks happy."
    text = plain(lexicon, [("nod", 0, 9)], 9.0, untimed=["talk", "smile"])
    assert text == "The woman talks and smiles. She nods the whole time."
    text = plain(lexicon, [], 9.0, untimed=["close_eyes"])
    assert text == "The woman closes her eyes."  # not that she keeps them closed


def test_texts_differ_and_the_same_key_gives_the_same(lexicon):
    told = scene(lexicon, [("talk", 0, 5), ("gaze", 0, 5), ("smile", 4, 9)], 9.0)
    found = texts_of(told, lexicon, 40, "0\0clip\0catalogue")
    assert len(set(found)) == len(found) == 40
    assert found == texts_of(told, lexicon, 40, "0\0clip\0catalogue")
    other = texts_of(told, lexicon, 40, "1\0clip\0catalogue")
    assert other[0] == found[0] and other[1:] != found[1:]


def test_there_are_as_many_texts_as_can_be_made(lexicon):
    mentions = lexicon.templates.mentions
    found = texts_of(scene(lexicon, [("EyeClose", 0, 0.2)], 9.0), lexicon, 1000, "key")
    assert len(found) == len(mentions)


def test_every_wording_of_the_figure_is_a_sentence_of_the_same_actions(lexicon):
    actions = [("talk", 0, 11), ("gaze", 0, 11), ("frown", 2, 3), ("blink", 4, 11)]
    told = scene(lexicon, actions, 11.0, uncertainty_s=1.0)
    for text in texts_of(told, lexicon, 500, "key"):
        assert "  " not in text and " ," not in text and ",," not in text and "{" not in text
        assert text[0].isupper() and text.endswith(".") and ".." not in text
        assert re.match(r"[^.]*\b(talk|gaze|talking|gazing)", text)
        first, *_, last = re.split(r"\b(?:woman|she)\b", text)[1:]
        assert "frown" not in first and "blink" not in first
        assert "blink" in last and "frown" not in last


def test_stretches_that_tell_the_same_are_told_for_what_they_are():
    lexicon = Lexicon(read_templates())
    parts = [Stretch(0, 4, ("talk",)), Stretch(6, 9, ("talk",), (Run(7, 7.5, "nod"),))]
    text = texts_of(Scene("male", ["man"], [], parts, 9.0, 1.0), lexicon, 1, "key")[0]
    assert text == (
        "To begin with, the man talks for some time, a little later, he talks for a short time, "
        "briefly nodding."
    )


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("plays_guitar", ("plays guitar", "play guitar", "playing guitar")),
        ("play_guitar", ("plays guitar", "play guitar", "playing guitar")),
        ("WaveHand", ("waves hand", "wave hand", "waving hand")),
        ("clap", ("claps", "clap", "clapping")),
        ("watches tv", ("watches tv", "watch tv", "watching tv")),
        ("cries", ("cries", "cry", "crying")),
        ("kiss", ("kisses", "kiss", "kissing")),
        ("lie", ("lies", "lie", "lying")),
        ("look-away", ("looks away", "look away", "looking away")),
        ("   ", ("acts", "act", "acting")),
    ],
)
def test_an_action_without_a_template_is_told_by_its_name(name, expected):
    assert forms(name) == expected


def test_a_name_that_looks_like_a_slot_is_put_in_as_it_stands(lexicon):
    own = Lexicon(read_templates())
    text = plain(own, [("waves_{their.mro}\x1b[31m", 0, 5)], 5.0)
    assert text == "The woman waves {their.mro}\N{REPLACEMENT CHARACTER}[31m the whole time."
    assert len(own.untold) == 1
