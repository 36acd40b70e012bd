"""What rules and adapters share: configuration, a stage's surroundings, a digest of its code."""

import ast
import hashlib
import logging
import re
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from mimeline.clips.exclusions import read_exclusions
from mimeline.config import validate
from mimeline.errors import MimelineError, NoSuchFile
from mimeline.room import FULL, NoRoom
from mimeline.vocabulary import SERIES_REGIONS, resource

PACKAGE = "mimeline"


def settle_config(config: dict[str, Any]) -> dict[str, Any]:
    """The validated, complete configuration; each mistake ends the program with one line.

    So does a file or folder that the configuration names and that is not there.
    """
    try:
        settled = validate(config)
    except ExceptionGroup as group:
        sys.exit("\n".join(f"mimeline: {problem}" for problem in group.exceptions))
    takes = chosen(settled["ingest"])
    named = (
        ("data_dir", settled["data_dir"], "folder", Path.is_dir),
        ("select.exclusions", settled["select"]["exclusions"], "file", Path.is_file),
        ("describe.templates", settled["describe"]["templates"], "file", Path.is_file),
        ("label.file", settled["label"]["file"], "file", Path.is_file),
        ("evaluate.truth", settled["evaluate"]["truth"], "file or folder", Path.exists),
        ("report.face", settled["report"]["face"], "file or folder", Path.exists),
        (f"ingest.{takes['format']}.face", face_of_takes(settled), "file", Path.is_file),
    )
    absent = [
        NoSuchFile(
            path,
            found=f"no such {kind}",
            expected=f"the {kind} that {key} names",
            remedy=f"Correct {key}, or set it to null.",
        )
        for key, path, kind, is_kind in named
        if path is not None and not is_kind(Path(path))
    ]
    if absent:
        sys.exit("\n".join(f"mimeline: {problem}" for problem in absent))
    _check_selection(settled["select"]["conditions"], settled["select"]["exclusions"])
    return settled


def _check_selection(conditions: Sequence[str], exclusions: str | None) -> None:
    """End the program where a condition or the list of exclusions cannot be read."""
    try:
        if conditions:
            from mimeline.clips.conditions import condition  # pandas with it: few runs need it

            for text in conditions:
                condition(text)
        if exclusions is not None:
            read_exclusions(exclusions)
    except MimelineError as error:
        sys.exit(f"mimeline: {error}")


def chosen(section: dict[str, Any]) -> dict[str, Any]:
    """A section's format and that format's keys: {format, options}, and no other format's."""
    return {"format": section["format"], "options": section.get(section["format"], {})}


def face_of_takes(config: dict[str, Any]) -> str | None:
    """Where the face model of the tracking results lies; None without one, and for the toy's."""
    face = chosen(config["ingest"])["options"].get("face")
    if face is None or config["data_dir"] is None:
        return None
    return str(Path(config["data_dir"], face))


def tracker_of_takes(config: dict[str, Any]) -> dict[str, Any] | None:
    """What reads a take's length, for a catalogue of files; None for one that tells it.

    A length needs no face model.
    """
    if config["catalogue"]["format"] != "files":
        return None
    tracker = chosen(config["ingest"]) | {"bad_values": config["ingest"]["bad_values"]}
    faceless = {"face": None} if "face" in tracker["options"] else {}
    return tracker | {"options": tracker["options"] | faceless}


def limits_of_videos(config: dict[str, Any]) -> dict[str, Any] | None:
    """What a video may ask of us, for a catalogue that videos tell of; None for every other."""
    if config["catalogue"]["format"] in ("celebvtext", "celebvhq", "files"):
        return None
    names = ("max_pixels", "max_source_s", "max_mb", "timeout_s")
    return {name: config["fetch"][name] for name in names}


def rate_of_clips(config: dict[str, Any]) -> str:
    """Frames per second to cut videos to, as text: fetch.fps, else the tracking results' own."""
    if config["fetch"]["fps"] is not None:
        return config["fetch"]["fps"]
    takes = chosen(config["ingest"])["options"]
    return str(Fraction(takes["fps"]) / takes.get("stride", 1))


def by_region(paths: Sequence[str]) -> dict[str, Path]:
    """Paths in the order of the series regions, by region."""
    return by_name(SERIES_REGIONS, paths)


def by_name(names: Sequence[Any], paths: Sequence[str]) -> dict[Any, Path]:
    """Paths in the order of these names, by name."""
    return {name: Path(path) for name, path in zip(names, paths, strict=True)}


def resource_table(name: str) -> str:
    """Path of a small static table, as an input of a rule.

    Told from this folder on where it lies below it, so that a checkout that was moved or copied
    runs nothing again.
    """
    path = resource(name)
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


def listing(path: str | None) -> str:
    """Fingerprint of a file, or of all files in a folder, by name, size and time."""
    if path is None:
        return "made on the way"
    digest = hashlib.sha256()
    root = Path(path)
    for file in sorted(root.rglob("*")) if root.is_dir() else [root]:
        if file.is_file():
            status = file.stat()
            entry = f"{file.relative_to(root)}\0{status.st_size}\0{status.st_mtime_ns}\n"
            digest.update(entry.encode(errors="surrogateescape"))
    return digest.hexdigest()[:16]


@contextmanager
def stage(snakemake) -> Iterator[SimpleNamespace]:
    """The surroundings of an adapter: log, one-line errors, outputs whole or not at all.

    Gives input, output, params, wildcards and threads. An output is a temporary path beside its
    target; all are moved into place when the block ends well, and removed when it does not.
    """
    handlers = _log_to(snakemake.log[0])
    lists = {name: path for name, path in snakemake.output.items() if not isinstance(path, str)}
    targets = {n: Path(p) for n, p in snakemake.output.items() if n not in lists}
    for name, paths in lists.items():
        targets |= {(name, number): Path(path) for number, path in enumerate(paths)}
    temporary = {name: path.with_name(f".{path.name}.making") for name, path in targets.items()}
    for path in temporary.values():
        path.parent.mkdir(parents=True, exist_ok=True)
        _remove(path)
    output = {name: path for name, path in temporary.items() if isinstance(name, str)}
    for name, paths in lists.items():
        output[name] = [temporary[name, number] for number in range(len(paths))]
    try:
        yield SimpleNamespace(
            input=snakemake.input,
            output=SimpleNamespace(**output),
            params=snakemake.params,
            wildcards=snakemake.wildcards,
            threads=snakemake.threads,
        )
        for name, path in temporary.items():
            _remove(targets[name])
            path.replace(targets[name])
    except MimelineError as error:
        logging.getLogger(PACKAGE).error("%s", error)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:
        if getattr(error, "errno", None) in FULL:
            folder = next(iter(targets.values())).parent
            logging.getLogger(PACKAGE).error("%s", NoRoom.of(folder, "the results"))
        else:
            logging.getLogger(PACKAGE).exception("an error of mimeline's own; please report it")
        sys.exit(1)
    finally:
        for path in temporary.values():
            _remove(path)
        for handler in handlers:
            logging.getLogger(PACKAGE).removeHandler(handler)
            handler.close()


def _log_to(path: str) -> tuple[logging.Handler, ...]:
    """The package's log goes to the rule's log file and to the terminal, through these."""
    logger = logging.getLogger(PACKAGE)
    logger.setLevel(logging.INFO)
    to_file, to_terminal = logging.FileHandler(path, mode="w"), logging.StreamHandler()
    to_file.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    to_terminal.setFormatter(logging.Formatter("mimeline: %(message)s"))
    for handler in (to_file, to_terminal):
        logger.addHandler(handler)
    return to_file, to_terminal


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def code_digest(*modules: str) -> str:
    """Digest of the first-party code that the modules run: their own and all that they import.

    Resource tables that the code names and a templates folder beside it count too; comments,
    docstrings and layout do not. Imports of names decided at run time are missed.
    """
    seen: set[str] = set()
    todo = list(modules)
    while todo:
        module = todo.pop()
        if module not in seen:
            seen.add(module)
            todo += _parsed(module)[1]
    digest = hashlib.sha256()
    for module in sorted(seen):
        digest.update(f"{module}\0{_parsed(module)[0]}\n".encode())
    return digest.hexdigest()[:16]


@cache
def _parsed(module: str) -> tuple[str, tuple[str, ...]]:
    """Digest of a module's code, and the first-party modules that it imports."""
    path = _source(module)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imported = {".".join(module.split(".")[:-1])} if "." in module else set()
    data = {file for file in path.parent.glob("templates/**/*") if file.is_file()}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                package = module if path.name == "__init__.py" else module.rpartition(".")[0]
                parents = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*parents, base] if base else parents)
            imported |= {base, *(f"{base}.{alias.name}" for alias in node.names)}
        _strip_docstring(node)
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            data |= {resource(node.value)} if _is_resource(node.value) else set()
    first_party = (name for name in imported if name.split(".")[0] == PACKAGE and _source(name))
    digest = hashlib.sha256(ast.dump(tree).encode())
    for file in sorted(data):
        digest.update(file.read_bytes())
    return digest.hexdigest(), tuple(sorted(first_party))


def _is_resource(name: str) -> bool:
    return re.fullmatch(r"[\w-]+\.\w+", name) is not None and resource(name).is_file()


def _strip_docstring(node: ast.AST) -> None:
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    if isinstance(node, kinds) and ast.get_docstring(node, clean=False) is not None:
        node.body = node.body[1:]


@cache
def _source(module: str) -> Path | None:
    """The module's file, found without running it; None where there is no such module."""
    root = Path(__file__).parent
    path = root.joinpath(*module.split(".")[1:])
    if path.is_dir():
        return path / "__init__.py"
    file = path.with_suffix(".py")
    return file if file.is_file() else None
