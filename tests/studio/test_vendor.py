"""What the pages use of other people's work: as it was built, with its licence."""

import hashlib
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
    assert not [name for name in FILES if "http" in (VENDOR / name).read_text()]
