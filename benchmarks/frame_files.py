"""How fast metrical-tracker's .frame files are read and written on one core: files per second.

python benchmarks/frame_files.py [--files 1000] [--repeats 5]

The files are written by torch.save, as the tracker does. The target is 1,500 files/s. Peers in the
same run: torch.load with weights_only and NumPy's names allowed, which is what the tracker's own
users are told to write, and pickle.loads of each file's pickle, which runs whatever it holds. CPU
seconds of this process, of one thread; the fastest of several repeats.
"""

import argparse
import pickle
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import torch

from mimeline.archives.torch_saved import read_saved
from mimeline.face.rotations import turned
from mimeline.tables import COEFFICIENTS
from mimeline.tracking.formats import metrical_tracker

TARGET = 1_500  # files a second


def made_up(n: int) -> tuple[pd.DataFrame, np.ndarray]:
    """FLAME's coefficients of n frames, and the rotations (n, 3, 3) of their heads."""
    rng = np.random.default_rng(0)
    names = COEFFICIENTS["flame"].schema.names[2:]
    return (
        pd.DataFrame(rng.normal(0, 0.2, (n, len(names))), columns=names),
        turned(*rng.normal(0, 0.2, (3, n))),
    )


def saved_by_torch(folder: Path, flame: pd.DataFrame, head: np.ndarray) -> list[Path]:
    """The same frames, each written by torch.save."""
    metrical_tracker.write(folder, flame, head)
    files = sorted((folder / metrical_tracker.CHECKPOINT).iterdir())
    for file in files:
        torch.save(torch.load(file, weights_only=False), file)
    return files


def rate(work, files: int, repeats: int) -> float:
    """Files per CPU second, the most of several runs; the first is not counted."""
    work()
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        taken.append(time.process_time() - start)
    return files / min(taken)


def unpickled(file: Path):
    with zipfile.ZipFile(file) as archive:
        return pickle.loads(archive.read(f"{file.stem}/data.pkl"))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--files", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    torch.set_num_threads(1)
    numpys = [np.ndarray, np.dtype, type(np.dtype("f4")), type(np.dtype("i8"))]
    numpys += [np._core.multiarray._reconstruct, np._core.multiarray.scalar]
    with tempfile.TemporaryDirectory() as folder, torch.serialization.safe_globals(numpys):
        flame, head = made_up(options.files)
        take = Path(folder) / "take"
        files = saved_by_torch(take, flame, head)
        works = {
            "a take, to motion": lambda: metrical_tracker.read(take, "25", None, "fail"),
            "a file, to arrays": lambda: [read_saved(file, "") for file in files],
            "torch.load, weights only": lambda: [torch.load(f, weights_only=True) for f in files],
            "pickle.loads, unsafe": lambda: [unpickled(file) for file in files],
            "written": lambda: metrical_tracker.write(Path(folder) / "other", flame, head),
        }
        size = files[0].stat().st_size
        print(f"{len(files)} files of {size} bytes; target {TARGET} files/s")
        for name, work in works.items():
            found = rate(work, len(files), options.repeats)
            print(f"{name:26} {found:8.0f} files/s  {found / TARGET:5.2f} of the target")


if __name__ == "__main__":
    main()
