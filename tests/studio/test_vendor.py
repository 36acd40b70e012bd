"""What the pages use of other people's work: as it was built, with its licence."""

import hashlib
import re
from pathlib import Path

import mimeline.studio

VENDOR = Path(mimeline.studio.__file__).parent / "static" / "vendor"
LIST = "VERSIONS"
FILES = {path.name for path in VENDOR.iterdir()} - {LIST}


def test_each_file_is_as_it_was_built():
    built = dict(line.split()[1::-1] for line in (VENDOR / LIST).read_text().splitlines())
    found = {n: hashlib.sha256((VENDOR / n).read_bytes()).hexdigest() for n in FILES}
    assert found == built


def test_each_file_has_its_licence_beside_it():
    assert FILES
    for name in FILES:
        licence = VENDOR / f"{Path(name).stem}.LICENSE"
        assert "Permission is hereby granted" in licence.read_text()


def test_nothing_in_it_names_a_place_to_load_from():
    place = re.compile(r"https?://(?!www\.w3\.org/1999/xhtml)\w")  # which names a kind of element
    assert not [name for name in FILES if place.search((VENDOR / name).read_text())]


def test_nothing_in_it_makes_code_of_text():
    makes = re.compile(r"\beval\(|\bnew Function\b|innerHTML|\bnew Worker\b")
    assert not [name for name in FILES if makes.search((VENDOR / name).read_text())]
