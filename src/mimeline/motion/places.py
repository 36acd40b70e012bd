"""Where motions are asked for: a file in each format, or a folder with those of each."""

from collections.abc import Collection, Sequence
from pathlib import Path

from mimeline.clips.admission import SAFE_ID
from mimeline.errors import BadFile
from mimeline.motion import files
from mimeline.motion.files import FORMATS
from mimeline.reporting import words
from mimeline.targets import is_folder, require_folder, require_free, require_new


def places(
    outs: Sequence[Path],
    to: Sequence[str],
    names: Sequence[str],
    sources: Collection[Path] = (),
    overwrite: bool = False,
) -> dict[str, list[Path]]:
    """Motion's name → the files that are to be written of it.

    outs: files, whose endings tell their formats, for one motion; or folders (a name without an
    ending is one), which get a file of each motion in each format of `to`. Raises BadFile for a
    file of several motions, a folder without a format, a name that is no plain file name, two
    motions of one name, one of the sources, and what is there already, unless overwrite allows to
    replace it.
    """
    endings = [ending_of(text) for text in to]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise BadFile(
            outs[0],
            found=f"two motions that are called {twice}",
            expected="each once",
            remedy="Write them one by one, into folders of their own.",
        )
    found: dict[str, list[Path]] = {name: [] for name in names}
    for out in dict.fromkeys(outs):
        if is_folder(out):
            _require_plain(out, names, endings)
            of_folder = {name: [out / f"{name}{e}" for e in endings] for name in names}
            landing = [_lands(path) for own in of_folder.values() for path in own]
            for path in require_new(out, landing, overwrite):
                if path.is_file():
                    require_free(path, sources, overwrite)
            for name, paths in of_folder.items():
                found[name] += paths
        elif len(names) != 1:
            raise BadFile(
                out,
                found=f"one file for {words.plural(len(names), 'motion')}",
                expected="a folder, which gets a file of each",
                remedy="Name a folder and say the format, as --to csv, or name one clip.",
            )
        else:
            files.format_of(out)
            if _lands(out) == out:
                require_free(out, sources, overwrite)
            else:
                require_folder(_lands(out))
                require_new(_lands(out).parent, [_lands(out)], overwrite)
            found[names[0]].append(out)
    return found


def ending_of(text: str) -> str:
    """The ending that a format's name or ending means (gltf, glb, .glb). Raises BadFile."""
    asked = text.casefold().removeprefix(".")
    for form in FORMATS.values():
        if asked in (form.name, form.ending.removeprefix(".")):
            return form.ending
    raise BadFile(
        "--to",
        found=repr(text),
        expected="a format of motion",
        remedy=f"There are {', '.join(ending.removeprefix('.') for ending in files.ENDINGS)}.",
    )


def _lands(path: Path) -> Path:
    """Where what is asked for as path will lie."""
    return path.with_suffix("") if files.format_of(path).name == "obj" else path


def _require_plain(folder: Path, names: Collection[str], endings: Sequence[str]) -> None:
    require_folder(folder)
    if not endings:
        raise BadFile(
            folder,
            found="a folder" if folder.is_dir() else "a name without an ending, as a folder has",
            expected="the format of the files in it",
            remedy="Say it, as --to csv,glb.",
        )
    for name in names:
        if not SAFE_ID.fullmatch(name):
            raise BadFile(
                folder,
                found=f"clip {name!r}",
                expected="ids that are plain file names (a-z 0-9 . _ -)",
                remedy="Rename the clip in the file that it is read from.",
            )
