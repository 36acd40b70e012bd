"""Runs of whole workflows, and the hand that stops one: each in a checkout of its own."""

import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import yaml

from .checkouts import CHECKOUT, CODE, PARTS, TINY, Workflow, copy_checkout, kill

KILLS = int(os.environ.get("MIMELINE_KILLS", "3"))
FIRST_S = (1.0, 8.0)  # from snakemake's start to the first signal, before there is any table
DELAY_S = 1.0  # at most, from a table to the signal
TAKEN = {"seconds"}  # a column that no two runs have in common
SMALL = {
    "shards": 1,
    "train": {"timeline": {"width": 16, "heads": 2, "steps": 5, "batch": 2}},
    "evaluate": {"timeline": {"timelines": 1, "sampler_steps": 2}},
    "report": {"clips": 1, "exemplars": 1},
}
NO_CLIP = {
    "toy": {"people": 2, "clips": 2, "video_share": 0},
    "select": {"min_s": 30, "max_s": 60},
    "shards": 1,
}
STUDIES = ("sweep", "experiments", "ablations")  # targets that `all` does not have
GRID = {
    "sweep": {"n_clusters": [3], "beta": [40.0], "seeds": 1},
    "experiments": {"seeds": 1},
    "ablations": {"variants": ["no-branch"], "seeds": 1, "timelines": 2, "frames": 136},
}
FINISHED = "finished"  # what the toy run left, whatever is done to it later
GOLDEN = CHECKOUT / "tests" / "tracking" / "golden"  # small takes of each format
# In the order in which the tests need them.
RUNS = (
    "toy_run",
    "clipless_run",
    "killed_run",
    "livelink_run",
    "dreamtalk_run",
    "pyfeat_run",
    "openface_run",
    "metrical_tracker_run",
    "videos_run",
    "celebvtext_run",
    "studied_run",
)


class Beside:
    """Whole runs that go on beside the tests, two at a time; names: some of RUNS."""

    def __init__(self, names: Collection[str]):
        self._folder = tempfile.TemporaryDirectory(prefix="mimeline-runs-")
        self._pool = ThreadPoolExecutor(2)
        ordered = [name for name in RUNS if name in names]
        self._runs = {}  # by name; a run may get those before it
        for name in ordered:
            self._runs[name] = self._pool.submit(self._run, name)

    def get(self, name: str) -> Any:
        """What a run gives, once it is over. Raises what went wrong in it."""
        return self._runs[name].result()

    def close(self) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in list(Workflow.running):
            kill(process)
        self._pool.shutdown()
        self._folder.cleanup()

    def _run(self, name: str) -> Any:
        root = Path(self._folder.name) / name
        real = Path(os.environ["MIMELINE_REAL_DATA"])
        match name:
            case "toy_run":
                return toy_run(root)
            case "studied_run":
                self.get("toy_run")
                return studied_run(root)
            case "clipless_run":
                return clipless_run(root)
            case "killed_run":
                self.get("toy_run")
                return killed_run(root)
            case "livelink_run":
                return example_run(root, "livelink", real / "arkit_livelink", change=SMALL)
            case "dreamtalk_run":
                return example_run(root, "dreamtalk", real / "dreamtalk", change=SMALL)
            case "pyfeat_run":
                return example_run(root, "pyfeat", real / "pyfeat", change=SMALL)
            case "openface_run":
                return example_run(root, "openface", real / "openface", until="pose", change=SMALL)
            case "metrical_tracker_run":
                return metrical_tracker_run(root)
            case "videos_run":
                return videos_run(root, real)
            case "celebvtext_run":
                return example_run(root, "celebvtext", real / "celebv", until="select")
        raise ValueError(name)


def toy_run(root: Path) -> Workflow:
    """A checkout in which `snakemake all` has run on the tiny toy world; a copy stays beside it."""
    workflow = copy_checkout(root, PARTS + CODE)
    done = workflow.run()
    assert done.returncode == 0, done.stdout + done.stderr
    shutil.copytree(root, root.with_name(FINISHED))
    return workflow


def studied_run(root: Path) -> tuple[Path, str]:
    """The results of a finished run, then tried with other settings, and what that said."""
    shutil.copytree(root.with_name(FINISHED), root)
    (root / "change.yaml").write_text(yaml.safe_dump(GRID))
    config = (TINY, str(root / "change.yaml"))
    done = Workflow(root, root / "src").run(*STUDIES, config=config)
    assert done.returncode == 0, done.stdout + done.stderr
    return root / "results", done.stdout + done.stderr


def clipless_run(root: Path) -> tuple[Path, str]:
    """The checkout of a run that loses every clip, and what the run said."""
    workflow = copy_checkout(root, PARTS)
    (root / "change.yaml").write_text(yaml.safe_dump(NO_CLIP))
    done = workflow.run(config=(TINY, str(root / "change.yaml")))
    assert done.returncode == 0, done.stdout + done.stderr
    return root, done.stdout + done.stderr


def example_run(
    root: Path, name: str, data: Path, *, until: str | None = None, change: dict | None = None
) -> Path:
    """The results of an example on a data folder, with some changed keys, until a stage."""
    workflow = copy_checkout(root, PARTS)
    (root / "change.yaml").write_text(yaml.safe_dump(change or {}))
    config = (f"config/examples/{name}.yaml", str(root / "change.yaml"))
    stop = ("--until", until) if until else ()
    done = workflow.run(*stop, "--config", f"data_dir={data}", config=config)
    assert done.returncode == 0, done.stdout + done.stderr
    return root / f"results-{name}"


def metrical_tracker_run(root: Path) -> Path:
    """Small takes, each a folder of a file per frame."""
    data, options = small_takes("metrical_tracker", root.with_name("takes"))
    change = {"shards": 1, "select": {"min_s": 0.1}, "ingest": {"metrical_tracker": options}}
    return example_run(root, "metrical_tracker", data, until="pose", change=change)


def small_takes(name: str, folder: Path) -> tuple[Path, dict]:
    """A folder of the small takes of a format, and how these are to be read."""
    folder.mkdir()
    for take in (GOLDEN / name).iterdir():
        if take.name != "options.yaml":
            (folder / take.name).symlink_to(take)
    return folder, yaml.safe_load((GOLDEN / name / "options.yaml").read_text())


def videos_run(root: Path, real: Path) -> Path:
    """Bare videos, two of them bad."""
    data = root.with_name("bare_videos")
    data.mkdir()
    for video in ("face_noface.mov", "no_face.mp4", "single_face.mp4"):
        (data / video).symlink_to(real / "video" / video)
    for video in ("empty.mp4", "single_face_truncated_100k.mp4"):
        (data / video).symlink_to(real / "corrupt" / video)
    return example_run(root, "videos", data, until="fetch", change={"fetch": {"side_px": 64}})


def killed_run(root: Path) -> tuple[Path, Path]:
    """The results of a run that was stopped KILLS times and once in training, and its reference.

    It is stopped before its first table, then after a random number of tables. Whatever stands in
    the results at such a moment is what stands in the reference: the results of a finished run.
    """
    workflow = copy_checkout(root, PARTS)
    results, reference = root / "results", root.with_name(FINISHED) / "results"
    moment = random.Random(KILLS)
    later = sorted(moment.sample(range(1, len(tables_in(reference))), KILLS - 1))
    for number, wanted in enumerate([0, *later]):
        with workflow.start() as process:
            while process.poll() is None and len(tables_in(results)) < wanted:
                time.sleep(0.05)
            with suppress(subprocess.TimeoutExpired):
                process.wait(moment.uniform(0, DELAY_S) if wanted else moment.uniform(*FIRST_S))
            assert process.poll() is None, f"over before table {wanted}"
            os.killpg(process.pid, signal.SIGKILL if number % 2 else signal.SIGINT)
            process.wait(timeout=120)
        assert_same_tables(results, reference)
        assert workflow.run("--unlock").returncode == 0
    done = workflow.run()
    assert done.returncode == 0, done.stdout + done.stderr
    stop_training(workflow, results)
    return results, reference


def stop_training(workflow: Workflow, results: Path) -> None:
    """Train anew; stop it as soon as there is something to resume it from, and go on."""
    checkpoint = "results/train/timeline/checkpoint"
    with workflow.start(checkpoint, "--forcerun", "train") as process:
        while process.poll() is None and not any(results.glob("train/timeline.state/*/*.json")):
            time.sleep(0.01)
        assert process.poll() is None, "over before anything was saved"
        os.killpg(process.pid, signal.SIGKILL)
        process.wait(timeout=120)
    assert workflow.run("--unlock").returncode == 0
    done = workflow.run(checkpoint)
    assert done.returncode == 0, done.stdout + done.stderr


def assert_same_tables(results: Path, reference: Path) -> None:
    """The tables that are in the results are whole, and those of the reference."""
    for name in tables_in(results):
        tables = [pq.read_table(folder / name) for folder in (results, reference)]
        found, expected = (t.drop_columns(list(TAKEN & {*t.column_names})) for t in tables)
        assert found.equals(expected), name


def tables_in(results: Path) -> set[str]:
    """The finished tables, by path in the results, in which a run may be going on meanwhile."""
    found = set()
    for folder, names, files in os.walk(results):  # passes over a folder that is gone by now
        names[:] = [name for name in names if not name.startswith(".")]
        finished = (Path(folder, name) for name in files if not name.startswith("."))
        found |= {str(p.relative_to(results)) for p in finished if p.suffix == ".parquet"}
    return found
