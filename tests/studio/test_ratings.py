import json
from pathlib import Path

import numpy as np
import pytest

from mimeline.errors import BadFile, MissingColumn, NoSuchFile
from mimeline.studio.rating_file import Rating, read_ratings, write_ratings
from mimeline.studio.ratings import as_json, as_text, interval, paper, ratings

RESULTS = "0123456789abcdef"


def rating(person: str, number: int, answer: int, kind: str = "annotation", **facts) -> Rating:
    told = {"view": "face", "question": "accurate", "seconds": 10.0, "results": RESULTS} | facts
    return Rating(person, f"{kind}{number}", kind, f"clip_{number}", answer=answer, **told)


@pytest.fixture
def write(tmp_path):
    def write(rows, name: str = "answers.csv") -> Path:
        write_ratings(tmp_path / name, rows)
        return tmp_path / name

    return write


def share(found, kind: str = "annotation", question: str = "accurate"):
    return next(s for s in found.shares if (s.kind, s.question) == (kind, question))


def test_the_share_that_agrees_counts_fours_and_fives(write):
    rows = [rating("ann", n, answer) for n, answer in enumerate((5, 4, 4, 3, 2))]
    rows += [rating("bo", n, answer) for n, answer in enumerate((5, 3, 3, 1, 1))]
    found = share(ratings([write(rows)]))
    assert (found.answers, found.persons, found.pairs) == (10, 2, 5)
    assert found.agree == pytest.approx(0.4)
    assert found.unsure == pytest.approx(0.3)
    assert found.mean == pytest.approx(3.1)
    assert found.low < 0.4 < found.high and found.over == "persons and pairs"


def test_kinds_and_questions_are_told_apart(write):
    rows = [rating("ann", 0, 5), rating("ann", 1, 5, "truth"), rating("ann", 2, 1, "mismatched")]
    rows.append(rating("ann", 0, 2, question="natural"))
    found = ratings([write(rows)])
    told = {(s.kind, s.question): s.agree for s in found.shares}
    assert told == {
        ("truth", "accurate"): 1.0,
        ("annotation", "accurate"): 1.0,
        ("mismatched", "accurate"): 0.0,
        ("annotation", "natural"): 0.0,
    }


def test_films_and_faces_are_told_apart(write):
    rows = [rating("ann", 0, 5), rating("ann", 1, 1, view="film")]
    found = ratings([write(rows)])
    assert {s.view: s.agree for s in found.shares} == {"face": 1.0, "film": 0.0}
    assert "annotation, film" in as_text(found)


def test_of_one_person_the_pairs_alone_are_resampled_and_that_is_said(write):
    found = ratings([write([rating("ann", n, 5 if n % 3 else 1) for n in range(12)])])
    assert share(found).over == "pairs"
    assert "one person answered" in as_text(found) and "crossed" not in as_text(found)


def test_one_answer_has_no_interval(write):
    found = ratings([write([rating("ann", 0, 4)])])
    assert share(found).low is None and share(found).high is None
    assert "annotation        1        1      1  100 %              –" in as_text(found)


def test_where_all_agree_the_interval_is_no_point(write):
    found = share(ratings([write([rating("ann", n, 5) for n in range(10)])]))
    assert found.over == "exact" and found.high == 1.0
    assert found.low == pytest.approx(0.6915, abs=1e-4)  # of Clopper and Pearson, 10 of 10
    none = share(ratings([write([rating("ann", n, 1) for n in range(10)])]))
    assert (none.low, none.high) == (0.0, pytest.approx(0.3085, abs=1e-4))


def test_the_crossed_bootstrap_is_wider_than_that_of_answers():
    """Persons who differ, and pairs that differ, make answers that go together."""
    rng = np.random.default_rng(0)
    logit = rng.normal(0, 1.5, (8, 1)) + rng.normal(0, 1.5, (1, 15))
    agrees = rng.random((8, 15)) < 1 / (1 + np.exp(-logit))
    low, high, _ = interval(agrees, np.ones_like(agrees), 2000, rng)
    share = agrees.mean()
    naive = 2 * 1.96 * np.sqrt(share * (1 - share) / agrees.size)
    assert high - low > 1.5 * naive


def test_the_interval_covers_what_it_should():
    """Of studies drawn from persons and pairs that differ, most intervals hold the true share."""
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(100):
        logit = rng.normal(0, 1, (12, 1)) + rng.normal(0, 1, (1, 15))
        agrees = rng.random((12, 15)) < 1 / (1 + np.exp(-logit))
        low, high, _ = interval(agrees, np.ones_like(agrees), 400, rng)
        held += low <= 0.5 <= high
    assert held >= 88


def test_answers_that_are_lacking_do_not_count():
    rng = np.random.default_rng(0)
    answered = rng.random((6, 10)) < 0.5
    agrees = rng.random((6, 10)) < 0.7
    once = interval(agrees, answered, 500, np.random.default_rng(2))
    again = interval(agrees | ~answered, answered, 500, np.random.default_rng(2))
    assert once == again


def test_each_person_has_a_line_with_what_they_say_of_mismatched_pairs(write):
    rows = [rating("ann", n, 1, "mismatched", seconds=5.0 + n) for n in range(4)]
    rows += [rating("bo", n, 5, "mismatched") for n in range(4)]
    found = ratings([write(rows)])
    ann, bo = found.persons
    assert (ann.pairs, ann.median_s, ann.mismatched, ann.agreed, ann.looks) == (4, 6.5, 4, 0, True)
    assert (bo.agreed, bo.looks) == (4, False)
    text = as_text(found)
    assert "bo agrees with 4 of 4 mismatched" in text and "ann agrees" not in text


def test_pairs_without_a_picture_count_nowhere_and_are_said(write):
    seen = [rating("ann", n, 4 + n % 2) for n in range(4)] + [rating("ann", 4, 2)]
    lost = [rating("ann", 9, 0), rating("ann", 9, 0, question="natural", seconds=99.0)]
    lost += [rating("bo", n, 0, "mismatched") for n in range(3)]
    found, without = ratings([write(seen + lost)]), ratings([write(seen)])
    assert (found.shares, found.pairs) == (without.shares, 5)
    ann, bo = found.persons
    assert (ann.pairs, ann.median_s, ann.unseen) == (5, 10.0, 1)
    assert (bo.pairs, bo.median_s, bo.mismatched, bo.unseen) == (0, None, 0, 3)
    text = as_text(found)
    assert "ann had no picture of 1 pair" in text and "bo had no picture of 3 pairs" in text
    with pytest.raises(BadFile, match="no answer"):
        ratings([write(lost)])


def test_without_mismatched_pairs_nobody_is_said_to_look(write):
    assert "nothing tells whether people looked" in as_text(ratings([write([rating("a", 0, 4)])]))


def test_the_published_shares_stand_beside(write):
    assert paper() == {
        ("annotation", "accurate"): 0.92,
        ("generation", "accurate"): 0.89,
        ("generation", "natural"): 0.86,
    }
    found = ratings([write([rating("ann", 0, 4), rating("ann", 1, 4, "truth")])])
    assert share(found).paper == 0.92 and share(found, "truth").paper is None
    assert "Ma et al." in as_text(found) and "92 %" in as_text(found)


def test_several_files_of_one_study_add_up(write):
    one = write([rating("ann", n, 4) for n in range(3)], "ann.csv")
    two = write([rating("bo", n, 1) for n in range(3)], "bo.csv")
    found = ratings([one, two])
    assert share(found).persons == 2 and share(found).agree == 0.5
    assert [person.name for person in found.persons] == ["ann", "bo"]


def test_an_answer_that_two_files_hold_is_refused(write):
    rows = [rating("ann", 0, 4)]
    with pytest.raises(BadFile, match="two.csv.*of ann that .*one.csv"):
        ratings([write(rows, "one.csv"), write(rows, "two.csv")])


def test_answers_about_different_results_are_not_added_up(write):
    one = write([rating("ann", 0, 4)], "one.csv")
    two = write([rating("bo", 0, 4, results="f" * 16)], "two.csv")
    with pytest.raises(BadFile, match="two.csv.*other results.*one by one"):
        ratings([one, two])


def test_files_without_an_answer_are_refused(write):
    with pytest.raises(BadFile, match="no answer"):
        ratings([write([])])


def test_what_was_written_comes_back(write):
    rows = [rating("'=ann", 0, 4, seconds=1.5), rating("-b,o", 1, 5)]
    assert read_ratings(write(rows)) == rows


@pytest.mark.parametrize(
    ("column", "cell", "message"),
    [
        ("answer", "6", "line 3.*answer '6'"),
        ("answer", "-1", "line 3.*answer '-1'"),
        ("answer", "agree", "line 3.*a number from 1 to 5"),
        ("kind", "guess", "line 3.*kind 'guess'.*truth, annotation"),
        ("question", "pretty", "line 3.*question 'pretty'"),
        ("view", "", "line 3.*view ''"),
        ("seconds", "nan", "line 3.*seconds 'nan'"),
        ("person", "", "line 3.*no person"),
    ],
)
def test_a_row_that_is_none_is_told_with_its_line(write, column, cell, message):
    path = write([rating("ann", 0, 4), rating("ann", 1, 4)])
    lines = path.read_text().splitlines()
    cells = dict(zip(lines[0].split(","), lines[2].split(","), strict=True)) | {column: cell}
    path.write_text("\n".join([*lines[:2], ",".join(cells.values())]))
    with pytest.raises(BadFile, match=message):
        read_ratings(path)


def test_a_row_of_too_few_cells_and_one_that_is_there_twice_are_told(write):
    path = write([rating("ann", 0, 4)])
    text = path.read_text()
    path.write_text(text + "ann,x\n")
    with pytest.raises(BadFile, match="line 3.*2 cells, expected 9"):
        read_ratings(path)
    path.write_text(text + text.splitlines()[1] + "\n")
    with pytest.raises(BadFile, match="line 3.*another answer of ann"):
        read_ratings(path)


def test_a_pair_that_is_two_things_is_told(write):
    path = write([rating("ann", 0, 4), rating("bo", 0, 4)])
    text = path.read_text()
    path.write_text(text.replace("bo,annotation0,annotation", "bo,annotation0,truth"))
    with pytest.raises(BadFile, match="line 3.*as truth, clip_0.*as annotation, clip_0"):
        read_ratings(path)


def test_a_file_that_is_no_table_of_answers_is_told(tmp_path):
    path = tmp_path / "answers.csv"
    with pytest.raises(NoSuchFile):
        read_ratings(path)
    path.write_text("clip_id,reason\na,b\n")
    with pytest.raises(MissingColumn, match="person, pair"):
        read_ratings(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadFile, match="UTF-8"):
        read_ratings(path)


def test_programs_read_the_same(write, mimeline):
    path = write([rating("ann", n, 4 + n % 2) for n in range(4)])
    found = ratings([path])
    held = json.loads(as_json(found))
    assert held["shares"][0]["agree"] == 1.0 and held["persons"][0]["looks"] is True
    said = mimeline("ratings", "--json", path)
    assert said.code == 0 and json.loads(said.out) == held


def test_no_line_of_the_text_is_wider_than_a_terminal(write):
    rows = [
        rating(who, n, 1 + n % 5, kind, question=question, view=view)
        for who in ("ann", "x" * 40)
        for n in range(6)
        for kind in ("truth", "annotation", "generation", "mismatched")
        for question in ("accurate", "natural")
        for view in (("film", "face")[n % 2],)
    ]
    assert max(map(len, as_text(ratings([write(rows)])).splitlines())) <= 100
