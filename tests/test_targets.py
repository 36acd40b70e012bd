import pytest

from mimeline.errors import BadFile
from mimeline.targets import is_folder, require_folder, require_free, require_new


@pytest.fixture
def there(tmp_path):
    (tmp_path / "a.csv").write_text("somebody's")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link.csv").symlink_to(tmp_path / "a.csv")
    return tmp_path


def test_a_name_that_is_free_may_be_written_and_a_file_only_where_one_says_so(there):
    require_free(there / "new.csv", [there / "a.csv"], overwrite=False)
    require_free(there / "a.csv", [], overwrite=True)
    with pytest.raises(BadFile, match=r"a\.csv: found a file already.*--overwrite"):
        require_free(there / "a.csv", [], overwrite=False)


@pytest.mark.parametrize("name", ["a.csv", "link.csv", "folder/../a.csv"])
def test_what_is_read_is_never_written_over_under_any_name(there, name):
    with pytest.raises(BadFile, match="the file that is read"):
        require_free(there / name, [there / "a.csv"], overwrite=True)


@pytest.mark.parametrize(("name", "found"), [("folder", "a folder"), ("link.csv", "a link")])
def test_only_files_are_replaced(there, name, found):
    with pytest.raises(BadFile, match=f"found {found}"):
        require_free(there / name, [], overwrite=True)


def test_a_folder_is_meant_by_one_that_is_there_or_a_name_without_an_ending(there):
    (there / "dotted.d").mkdir()
    (there / "plain").touch()
    told = {n: is_folder(there / n) for n in ("folder", "dotted.d", "new", "new.csv", "plain")}
    assert told == {
        "folder": True,
        "dotted.d": True,
        "new": True,
        "new.csv": False,
        "plain": False,
    }
    require_folder(there / "new")
    require_folder(there / "folder")
    with pytest.raises(BadFile, match="found a file"):
        require_folder(there / "a.csv")


def test_files_of_clips_that_are_there_are_named_and_counted(there):
    paths = [there / name for name in ("a.csv", "link.csv", "new.csv")]
    with pytest.raises(BadFile, match=r"found a\.csv and 1 more already"):
        require_new(there, paths, overwrite=False)
    assert require_new(there, paths, overwrite=True) == paths[:2]
    assert require_new(there, paths[2:], overwrite=False) == []
