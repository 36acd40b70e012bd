"""The clusters of a run for a page: their facts, their exemplars and the curves around them."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from mimeline import tables
from mimeline.annotation.fitted import is_fitted, read_channels, read_fingerprint
from mimeline.clips.media_of_run import files_of
from mimeline.errors import BadFile, MimelineError, NoSuchFile
from mimeline.reporting.clusters import CONTEXT_FRAMES, CONTEXT_SHARE, scale_end
from mimeline.run import recall
from mimeline.studio.watched import stamp
from mimeline.vocabulary import SERIES_REGIONS, series_channels

FURTHER = "further"  # the kind of exemplar that is for a person who is not sure
MOST_PICTURES = 96  # of a sheet: longer stretches show every second frame, or third …
DIGITS = 3  # of a curve's values


@dataclass(frozen=True, eq=False)
class Exemplar:
    """An interval [start, end) with what is shown around it, the frames [first, stop).

    curves: channel → its value at each of those frames, None where it was not measured.
    views: kinds of pictures that there may be. fps: None where it is not known.
    """

    region: str
    cluster: int
    rank: int
    kind: str
    clip_id: str
    start: int
    end: int
    first: int
    stop: int
    fps: float | None
    views: tuple[str, ...]
    curves: Mapping[str, list[float | None]]

    @property
    def interval(self) -> tuple[str, int, int]:
        return self.clip_id, self.start, self.end

    @property
    def frames(self) -> list[int]:
        """Those with a picture, evenly spaced."""
        step = math.ceil((self.stop - self.first) / MOST_PICTURES)
        return list(range(self.first, self.stop, step))


@dataclass(frozen=True, eq=False)
class Region:
    """A region's clusters; none, for a reason.

    left_out: channels that hardly move, which the clusters were fitted without. top: the end of the
    curves' scale. proposed, profiles: rows of the tables, by cluster. exemplars: by cluster, in
    their order.
    """

    name: str
    fingerprint: str
    channels: tuple[str, ...]
    left_out: tuple[str, ...]
    reason: str
    top: float
    proposed: pd.DataFrame
    profiles: pd.DataFrame
    exemplars: Mapping[int, list[Exemplar]]

    @property
    def unmeasured(self) -> list[str]:
        """Actions that none of the fit's channels tells."""
        return list(self.proposed["unmeasured"].iloc[0]) if len(self.proposed) else []


class ClustersOfRun:
    """Read once, when the page is started; of the long tables only what the exemplars need.

    results: a run's results, up to `exemplars` at least. Raises NoSuchFile where there is no run,
    or it is not there yet, BadFile for a table that cannot be read.
    """

    def __init__(self, results: str | Path):
        self.results = Path(results)
        self.folder = self.results / "label"
        self.run = recall(self.results)
        self._refuse_unready()
        self._read = self._state()
        self.films = files_of(self.results, "film")
        self.motions = sorted(self.results.glob("ingest/*/motion.parquet"))
        self._rates = self._clips()
        self.regions = {region.name: region for region in self._regions()}
        if not any(len(region.proposed) for region in self.regions.values()):
            why = "; ".join(f"{r.name}: {r.reason}" for r in self.regions.values())
            raise NoSuchFile(
                self.folder,
                found=f"no cluster ({why})",
                expected="clusters to name",
                remedy="`mimeline funnel` and `mimeline why` tell what became of the clips.",
            )
        self._segments: dict[str, pd.DataFrame] = {}

    @cached_property
    def rate(self) -> float | None:
        """The usual frames per second."""
        rates = self._rates["fps"].dropna()
        return float(rates.median()) if len(rates) else None

    def exemplars(self) -> Iterator[Exemplar]:
        for region in self.regions.values():
            for own in region.exemplars.values():
                yield from own

    def clusters(self, region: str) -> pd.DataFrame:
        """The `clusters` table of a region."""
        if region not in self._segments:
            path = self.results / "segment" / region / "clusters.parquet"
            self._segments[region] = tables.read(
                tables.CLUSTERS, path, tables.CLUSTERS.schema.names
            )
        return self._segments[region]

    def facts(self, region: str, cluster: int) -> dict[str, Any]:
        """What is told of a cluster; purity rests on the proposals' rule."""
        of = self.regions[region]
        profile = of.profiles.loc[cluster]
        own = of.exemplars.get(cluster, [])
        median = float(profile["median_frames"])
        return {
            "number": cluster,
            "share": float(of.proposed.loc[cluster, "share"]),
            **{name: int(profile[name]) for name in ("n_frames", "n_intervals", "n_clips")},
            "median_frames": median,
            "median_s": median / self.rate if self.rate else None,
            "purity": _number(profile["purity"]),
            "nearest": None if pd.isna(profile["nearest"]) else int(profile["nearest"]),
            "distance": _number(profile["distance"]),
            "n_exemplars": len(own),
        }

    def refuse_refitted(self) -> None:
        """Raise BadFile where the results are no longer those that were read."""
        try:
            same = self._state() == self._read
        except MimelineError:  # it is being fitted now
            same = False
        if not same:
            there = self.folder.is_dir()
            raise BadFile(
                self.folder,
                found="another fit: the run was refitted meanwhile"
                if there
                else "nothing: the results were moved or deleted",
                expected="the clusters that this page was started with",
                remedy="Start mimeline label again; what was answered is written.",
            )

    def _refuse_unready(self) -> None:
        if all(stamp(self.folder / f"{name}.parquet") for name in ("exemplars", "profiles")):
            return
        begun = stamp(self.results / "run.json") or any(self.results.glob("series/*.parquet"))
        goal = self.run.command("--until", "exemplars")
        raise NoSuchFile(
            self.folder if begun else self.results,
            found="no exemplars yet" if begun else "no run",
            expected="the results of a run up to exemplars",
            remedy=f"Run `{goal}`."
            if begun
            else f"Run `{goal}`, or name the folder of another run with --results.",
        )

    def _state(self) -> list:
        folders = [self.results / "segment" / region / "model" for region in SERIES_REGIONS]
        fits = [read_fingerprint(folder) if is_fitted(folder) else "" for folder in folders]
        return [*fits, stamp(self.folder / "exemplars.parquet")]

    def _clips(self) -> pd.DataFrame:
        """fps and n_frames by clip, null where they are not known."""
        columns = ["clip_id", "fps_num", "fps_den", "n_frames"]
        rows = tables.read_all(tables.CLIPS, self.results.glob("pose/*/clips.parquet"), columns)
        rows = rows.drop_duplicates("clip_id").set_index("clip_id").astype("Float64")
        return rows.assign(fps=rows["fps_num"] / rows["fps_den"]).astype("float64")

    def _regions(self) -> Iterator[Region]:
        proposed = tables.read(tables.LABELS, self.folder / "proposed.parquet")
        profiles = tables.read(tables.PROFILES, self.folder / "profiles.parquet")
        shown = tables.read(tables.EXEMPLARS, self.folder / "exemplars.parquet")
        for region in SERIES_REGIONS:
            rows = shown[shown["region"] == region]
            yield self._region(region, _of(proposed, region), _of(profiles, region), rows)

    def _region(
        self, region: str, proposed: pd.DataFrame, profiles: pd.DataFrame, shown: pd.DataFrame
    ) -> Region:
        series = self.results / "series" / f"{region}.parquet"
        channels = _channels(region, series)
        if proposed.empty:
            clusters = self.results / "segment" / region / "clusters.parquet"
            reason = tables.reason(clusters) or tables.reason(series) or "no cluster was found"
            return Region(region, "", channels, (), reason, 1.0, proposed, profiles, {})
        model = self.results / "segment" / region / "model"
        side = "left" if channels == series_channels(region, "left") else "right"
        frames = tables.read(
            tables.SERIES[region, side],
            series,
            ["clip_id", "frame", *channels],
            clips=shown["clip_id"].unique(),
        )
        by_clip = dict(iter(frames.groupby("clip_id")))
        exemplars: dict[int, list[Exemplar]] = {}
        for row in shown.sort_values(["cluster", "rank"]).itertuples():
            if row.clip_id in by_clip:
                own = exemplars.setdefault(int(row.cluster), [])
                own.append(self._exemplar(row, by_clip[row.clip_id], channels))
        return Region(
            region,
            read_fingerprint(model),
            channels,
            tuple(name for name in channels if name not in read_channels(model)),
            "",
            scale_end(frames[list(channels)].to_numpy("float64")),
            proposed,
            profiles,
            exemplars,
        )

    def _exemplar(self, row, frames: pd.DataFrame, channels: tuple[str, ...]) -> Exemplar:
        number = frames["frame"].to_numpy("int64")
        known = self._rates.loc[row.clip_id] if row.clip_id in self._rates.index else None
        length = None if known is None else _number(known["n_frames"])
        start, end = int(row.start_frame), int(row.end_frame)
        context = CONTEXT_FRAMES + round(CONTEXT_SHARE * (end - start))
        first = max(0, start - context)
        stop = max(end, min(int(length or number[-1] + 1), end + context))
        near = (number >= first) & (number < stop)
        dense = np.full((stop - first, len(channels)), np.nan)  # a frame that is masked stays a gap
        dense[number[near] - first] = frames.loc[near, list(channels)].to_numpy("float64")
        curves = zip(channels, dense.T.round(DIGITS).tolist(), strict=True)
        views = ("film",) * (row.clip_id in self.films) + ("face",) * bool(self.motions)
        return Exemplar(
            row.region,
            int(row.cluster),
            int(row.rank),
            row.kind,
            row.clip_id,
            start,
            end,
            first,
            stop,
            None if known is None else _number(known["fps"]),
            views,
            {name: [None if math.isnan(v) else v for v in values] for name, values in curves},
        )


def _of(rows: pd.DataFrame, region: str) -> pd.DataFrame:
    return rows[rows["region"] == region].set_index("cluster", drop=False)


def _channels(region: str, series: Path) -> tuple[str, ...]:
    """The series' channels, of whichever side of the face it was made from."""
    there = pq.read_schema(series).names
    sides = (series_channels(region, side) for side in ("left", "right"))
    return next(names for names in sides if set(names) <= set(there))


def _number(value) -> float | None:
    return None if pd.isna(value) else float(value)
