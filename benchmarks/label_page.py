"""How soon the label page is there, and how soon an exemplar's pictures are.

python benchmarks/label_page.py [--results results] [--times 1]

Seconds from the start of `mimeline label` to its address and to the first /state, the fastest of
three starts, and the most memory it held; the limit is 3 s. Then, per cluster, the sheets of the
exemplars that are shown at first, all views, in CPU seconds: cold, one after the other, and warm.
The first row holds what is loaded once: the motion around the exemplars and the face. With --times
the run's clips are repeated so often, under other names: 600,000 frames out of a small run.
"""

import argparse
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from http.cookiejar import CookieJar
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from mimeline.studio.clusters_of_run import FURTHER, ClustersOfRun
from mimeline.studio.pictures import Pictures

LIMIT_S, STARTS = 3.0, 3
REPEATED = ("pose/*/clips", "ingest/*/motion", "series/*", "segment/*/clusters")


def repeated(results: Path, times: int, into: Path) -> Path:
    """A copy of a run whose clips stand in its long tables so many times."""
    into = shutil.copytree(results, into / results.name)
    for pattern in REPEATED:
        for path in into.glob(f"{pattern}.parquet"):
            once = pq.read_table(path)
            clip_id, at = once["clip_id"].to_pandas(), once.column_names.index("clip_id")
            more = [once]
            for number in range(1, times):
                names = pa.array(clip_id + f"-{number}", pa.string(), from_pandas=True)
                more.append(once.set_column(at, once.schema.field(at), names))
            pq.write_table(pa.concat_tables(more), path, compression="zstd")
    return into


def started(results: Path, folder: Path) -> tuple[float, float, float]:
    """Seconds to the address and to the first state, and megabytes at most."""
    begin = time.perf_counter()
    command = [sys.executable, "-c", "from mimeline.cli import main; main()", "label"]
    command += ["--results", results, "--file", folder / "names.yaml", "--no-browser"]
    child = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, text=True)
    try:
        address = re.search(r"http://\S+", child.stdout.readline())[0]
        to_address = time.perf_counter() - begin
        opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
        opener.open(address).read()
        opener.open(f"{address.partition('?')[0]}state").read()
        to_state = time.perf_counter() - begin
        status = Path(f"/proc/{child.pid}/status").read_text()
        most = int(re.search(r"VmHWM:\s*(\d+)", status)[1]) / 1024
    finally:
        child.send_signal(signal.SIGINT)
        child.communicate()
    return to_address, to_state, most


def sheets(results: Path) -> list[tuple[str, int, float, float, float]]:
    """Per cluster: its name, how many sheets, kilobytes, CPU seconds cold and warm."""
    run = ClustersOfRun(results)
    pictures, rows = Pictures(run, None), []
    for region in run.regions.values():
        for cluster, exemplars in region.exemplars.items():
            keys = [(v, e.rank) for e in exemplars if e.kind != FURTHER for v in e.views]
            taken = []
            for _ in range(2):
                begin = time.process_time()
                made = [pictures.sheet(v, region.name, cluster, rank) for v, rank in keys]
                taken.append(time.process_time() - begin)
            size = sum(map(len, filter(None, made))) / 1024
            rows.append((f"{region.name} {cluster}", len(keys), size, *taken))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=Path, default=Path("results"))
    parser.add_argument("--times", type=int, default=1)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        results = chosen.results
        if chosen.times > 1:
            results = repeated(results, chosen.times, Path(folder))
        tables = results.glob("segment/*/clusters.parquet")
        frames = sum(pq.read_metadata(path).num_rows for path in tables)
        to_address, to_state, most = min(started(results, Path(folder)) for _ in range(STARTS))
        print(f"{frames:,} frames of all regions")
        print(f"address {to_address:.2f} s · first state {to_state:.2f} s (limit {LIMIT_S:g} s)")
        print(f"memory at most {most:.0f} MB")
        rows = sheets(results)
    table = pd.DataFrame(rows, columns=["cluster", "sheets", "KB", "cold s", "warm s"])
    print(table.to_string(index=False, float_format=lambda v: f"{v:.4g}"))
    cold = table["cold s"].to_numpy()
    print(
        f"first {cold[0]:.2f} s, then median {np.median(cold[1:]):.2f}, most {cold[1:].max():.2f} s"
    )


if __name__ == "__main__":
    main()
