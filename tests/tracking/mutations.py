"""Ways to spoil a take: its bytes, its cells, its arrays, its files. Every choice is drawn."""

import contextlib
import io
import json
import pickle
import shutil
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from hypothesis import strategies as st

Draw = Callable[[st.SearchStrategy], Any]

CELLS = (
    *("", " ", "nan", "-nan(ind)", "inf", "-inf", "1e400", "1e30", "-1e30", "9" * 400, "-1", "2.5"),
    *("0x10", "1_000", "1,5", "١٢", "½", "é", "\0", "'", '"', '"unclosed', "true", "None", "=1+1"),
    *("180", "100", "-0", "1e-400", "1000001", "4000", "01:02:03:04", "\n", "\r", "0", "1", "3"),
)
VALUES = (
    *(None, True, "", "x", "\0", [], {}, [[]], {"a": {}}, 0, -1, 3, 1e30, -1e300, 10**400, 2.5),
    *(float("nan"), float("inf"), "1e999", [0.5] * 3, "AU01_r", [1, [2, [3]]], -(2**63), 2**63),
)
TYPES = ("f2", "f8", "i1", "i8", "u8", "?", "c16", "U5", "S5", "O", "M8[s]")
NAMES = ("00000.frame", "99999999999.frame", "-1.frame", "x", "a\nb.csv", "frame.npy", "1.npy", "é")
DEEP = 100_000  # brackets in brackets


def spoil(path: Path, outside: Path, draw: Draw) -> None:
    """Spoil the file or folder at path once. outside: a file that no reader may follow a link to
    and change."""
    if path.is_dir() and not path.is_symlink():
        files = sorted(file for file in path.rglob("*") if file.is_file())
        if files and draw(st.integers(0, 2)):
            return spoil(draw(st.sampled_from(files)), outside, draw)
        return _spoil_folder(path, files, outside, draw)
    if not path.is_file():
        return None
    inside = {
        ".csv": [_spoil_cells] * 3,
        ".json": [_spoil_json] * 3,
        ".npy": [_spoil_arrays] * 2,
        ".npz": [_spoil_arrays] * 2 + [_spoil_member],
        ".mat": [_spoil_arrays] * 2,
        ".frame": [_spoil_pickle] * 2 + [_spoil_member],
    }.get(path.suffix, [])
    how = draw(st.sampled_from([*inside, _spoil_bytes, _spoil_bytes, _replace]))
    return how(path, draw) if how is not _replace else _replace(path, outside, draw)


def _spoil_folder(path: Path, files: list[Path], outside: Path, draw: Draw) -> None:
    how = draw(st.sampled_from(["empty", "remove", "rename", "copy", "add", "folder", "link"]))
    if how == "empty" or not files:
        shutil.rmtree(path)
        path.mkdir()
        return
    file = draw(st.sampled_from(files))
    other = file.with_name(draw(st.sampled_from([*NAMES, *(f.name for f in files)])))
    if other.is_dir():  # an earlier spoiling left a folder there
        shutil.rmtree(other)
    if how == "remove":
        file.unlink()
    elif how == "rename":
        file.replace(other)
    elif how == "copy" and other != file:
        shutil.copyfile(file, other)
    elif how == "add":
        other.write_bytes(draw(st.binary(max_size=20)))
    elif how == "folder":
        file.unlink()
        file.mkdir()
    else:
        _replace(file, outside, draw)


def _replace(path: Path, outside: Path, draw: Draw) -> None:
    """Something else in a file's place: nothing, a folder, a link."""
    path.unlink()
    how = draw(st.sampled_from(["nothing", "folder", "itself", "nowhere", "outside", "above"]))
    if how == "folder":
        path.mkdir()
    elif how != "nothing":
        targets = {"itself": path, "nowhere": path.with_name("nowhere"), "outside": outside}
        path.symlink_to(targets.get(how, path.parent))


def _spoil_bytes(path: Path, draw: Draw) -> None:
    path.write_bytes(_spoiled(path.read_bytes(), draw))


def _spoiled(data: bytes, draw: Draw) -> bytes:
    at = draw(st.integers(0, len(data)))
    length = draw(st.integers(1, max(1, min(64, len(data) - at))))
    how = draw(st.sampled_from(["cut", "flip", "flip", "insert", "delete", "repeat", "zero"]))
    before, chunk, after = data[:at], data[at : at + length], data[at + length :]
    if how == "cut":
        return before
    if how == "flip":
        mask = draw(st.integers(1, 255))
        return before + bytes(byte ^ mask for byte in chunk[:1]) + chunk[1:] + after
    if how == "insert":
        return before + draw(st.binary(min_size=1, max_size=32)) + chunk + after
    if how == "repeat":
        return before + chunk * draw(st.integers(2, 40)) + after
    if how == "zero":
        return before + bytes(len(chunk)) + after
    return before + after


def _spoil_member(path: Path, draw: Draw) -> None:
    """A file of a zip archive, under a checksum that is right."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    except (OSError, ValueError, zipfile.BadZipFile, zlib.error, NotImplementedError):
        return _spoil_bytes(path, draw)
    if not members:
        return _spoil_bytes(path, draw)
    name = draw(st.sampled_from(sorted(members)))
    how = draw(st.sampled_from(["bytes", "bytes", "drop", "twice", "rename", "bomb"]))
    if how == "bytes":
        members[name] = _spoiled(members[name], draw)
    elif how == "drop":
        del members[name]
    elif how == "rename":
        members[draw(st.sampled_from(["../outside", "/x", "a/../b", "x.npy"]))] = members.pop(name)
    elif how == "bomb":
        members[name] += bytes(5_000_000)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for key, data in members.items():
            archive.writestr(key, data)
            if how == "twice" and key == name:
                archive.writestr(zipfile.ZipInfo(key + "2"), data)
    return None


def _spoil_cells(path: Path, draw: Draw) -> None:
    """Rows, columns and cells of a table."""
    text = path.read_text("utf-8", errors="surrogateescape")
    rows = [line.split(",") for line in text.splitlines()] or [[""]]
    row, other = (draw(st.integers(0, len(rows) - 1)) for _ in range(2))
    width = max(len(cells) for cells in rows)
    column, second = (draw(st.integers(0, width - 1)) for _ in range(2))
    how = draw(
        st.sampled_from(
            [
                *["cell"] * 4,
                *(
                    "header",
                    "scale",
                    "drop row",
                    "repeat row",
                    "swap rows",
                    "drop column",
                    "ragged",
                ),
                *("repeat column", "swap columns", "fill column", "no header"),
                *("ragged", "longer row", "separator", "encoding", "ends"),
            ]
        )
    )
    separator, end, encoding = ",", "\n", "utf-8"
    if how in ("cell", "header"):
        cells = rows[0] if how == "header" else rows[row]
        cells[min(column, len(cells) - 1)] = draw(st.sampled_from(CELLS))
    elif how == "scale":
        cells = rows[row]
        at = min(column, len(cells) - 1)
        with contextlib.suppress(ValueError):
            cells[at] = str(float(cells[at]) * draw(st.sampled_from([-1, 1e-3, 57.3, 1e3, 1e300])))
    elif how == "drop row":
        del rows[row]
    elif how == "repeat row":
        rows.insert(other, list(rows[row]))
    elif how == "swap rows":
        rows[row], rows[other] = rows[other], rows[row]
    elif how == "drop column":
        rows = [cells[:column] + cells[column + 1 :] for cells in rows]
    elif how == "repeat column":
        rows = [cells[: column + 1] + cells[column:] for cells in rows]
    elif how == "swap columns":
        for cells in rows:
            if max(column, second) < len(cells):
                cells[column], cells[second] = cells[second], cells[column]
    elif how == "fill column":
        value = draw(st.sampled_from(CELLS))
        rows[1:] = [[*cells[:column], value, *cells[column + 1 :]] for cells in rows[1:]]
    elif how == "no header":
        del rows[0]
    elif how == "ragged":
        rows[row] = rows[row][:column]
    elif how == "longer row":
        rows[row] = rows[row] + ["1"] * draw(st.integers(1, 3))
    elif how == "separator":
        separator = draw(st.sampled_from([";", "\t", ", ", " "]))
    elif how == "ends":
        end = draw(st.sampled_from(["\r\n", "\r", "\n\n", ""]))
    else:
        encoding = draw(st.sampled_from(["utf-16", "utf-8-sig", "utf-32", "utf-7"]))
    text = end.join(separator.join(cells) for cells in rows) + end
    path.write_bytes(text.encode(encoding, errors="replace"))


def _spoil_json(path: Path, draw: Draw) -> None:
    if not draw(st.integers(0, 15)):
        path.write_text(draw(st.sampled_from(["[" * DEEP, '{"a":' * DEEP, "9" * 5000, "NaN"])))
        return None
    try:
        tree = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        return _spoil_bytes(path, draw)
    path.write_text(json.dumps(_spoiled_tree(tree, draw), default=str))
    return None


def _spoil_pickle(path: Path, draw: Draw) -> None:
    """What a golden take's own pickle holds."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        name = next(name for name in members if name.endswith("data.pkl"))
        tree = pickle.loads(members[name])  # made by the golden script, spoiled at most by itself
        members[name] = pickle.dumps(_spoiled_tree(tree, draw), draw(st.integers(0, 5)))
    except Exception:  # spoiled before
        return _spoil_bytes(path, draw)
    with zipfile.ZipFile(path, "w") as archive:
        for key, data in members.items():
            archive.writestr(key, data)
    return None


def _spoil_arrays(path: Path, draw: Draw) -> None:
    """Arrays of npy, npz and mat files: shapes, types, numbers, names."""
    buffer = io.BytesIO()
    try:
        if path.suffix == ".mat":
            tree = scipy.io.loadmat(path)
            tree = {k: v for k, v in tree.items() if not k.startswith("__")}
            scipy.io.savemat(buffer, _spoiled_tree(tree, draw))
        elif path.suffix == ".npz":
            with np.load(path) as arrays:
                tree = _spoiled_tree(dict(arrays), draw)
            np.savez(buffer, **tree)
        else:
            np.save(buffer, _spoiled_tree(np.load(path), draw))
    except Exception:  # spoiled before, or nothing that the format can hold
        return _spoil_bytes(path, draw)
    path.write_bytes(buffer.getvalue())
    return None


def _spoiled_tree(node: Any, draw: Draw) -> Any:
    """The same tree of dictionaries, lists and arrays but for one node of it."""
    if isinstance(node, dict) and node:
        key = draw(st.sampled_from(sorted(node, key=str)))
        how = draw(st.sampled_from([*["into"] * 6, "drop", "rename", "add", "replace"]))
        if how == "into":
            return node | {key: _spoiled_tree(node[key], draw)}
        if how == "drop":
            return {k: v for k, v in node.items() if k != key}
        if how == "rename":
            name = draw(st.sampled_from(["x", f"{key}2", str(key).upper(), ""]))
            return {name if k == key else k: v for k, v in node.items()}
        if how == "add":
            return node | {"more": node[key]}
    if isinstance(node, list) and node and draw(st.integers(0, 5)):
        at = draw(st.integers(0, len(node) - 1))
        how = draw(st.sampled_from(["into", "into", "into", "drop", "repeat", "swap"]))
        if how == "into":
            return [*node[:at], _spoiled_tree(node[at], draw), *node[at + 1 :]]
        if how == "drop":
            return node[:at] + node[at + 1 :]
        if how == "repeat":
            return node[: at + 1] + node[at:]
        return node[at:] + node[:at]
    if isinstance(node, np.ndarray) and draw(st.integers(0, 5)):
        return _spoiled_array(node, draw)
    return draw(st.sampled_from(VALUES))


def _spoiled_array(array: np.ndarray, draw: Draw) -> np.ndarray:
    how = draw(st.sampled_from(["number", "number", "shape", "type", "cut", "longer", "order"]))
    if how == "number" and array.size and array.dtype.kind in "fiu":
        array = array.copy()
        value = draw(st.sampled_from([np.nan, np.inf, -np.inf, 1e30, -7, 100, 1e-30]))
        with contextlib.suppress(ValueError, OverflowError):
            array.flat[draw(st.integers(0, array.size - 1))] = value
        return array
    if how == "shape":
        shapes = [array.reshape(-1), array[None], array.T, np.array(0.5), array[..., None]]
        return shapes[draw(st.integers(0, len(shapes) - 1))]
    if how == "type":
        with contextlib.suppress(ValueError, TypeError):
            return array.astype(draw(st.sampled_from(TYPES)))
    if how == "longer" and array.ndim:
        return np.repeat(array, 2, axis=draw(st.integers(0, array.ndim - 1)))
    if how == "order" and array.ndim:
        return np.asfortranarray(array[::-1])
    return array[: draw(st.integers(0, 1))] if array.ndim else array
