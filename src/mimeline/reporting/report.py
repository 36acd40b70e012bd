"""The report: one page, complete in itself, that a run ends with."""

import logging
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mimeline import tables
from mimeline.annotation.timelines import read_truth
from mimeline.reporting import gauge, words
from mimeline.reporting.album import Album
from mimeline.reporting.captions import captions
from mimeline.reporting.channels import channels
from mimeline.reporting.clusters import GAP, HEIGHT, LEADERS, WIDTH, regions
from mimeline.reporting.confusion import matrices
from mimeline.reporting.evidence import evidence
from mimeline.reporting.funnel import STATUSES, funnel
from mimeline.reporting.generated import pictures
from mimeline.reporting.labelling import labelling as spent
from mimeline.reporting.motion_scores import VARIANT_WORDS
from mimeline.reporting.page import write_page
from mimeline.reporting.pairs import pairs
from mimeline.reporting.scores import scores
from mimeline.reporting.sheet import sheet, shown
from mimeline.reporting.shows import shows
from mimeline.reporting.stand_in import stand_in
from mimeline.reporting.stills import stills
from mimeline.reporting.summary import figures, lead, missing
from mimeline.reporting.timelines import timelines
from mimeline.reporting.training import model
from mimeline.vocabulary import ACTIONS, TRACKS, track_actions

log = logging.getLogger(__name__)

GENERATED = 3  # requested timelines drawn per model


def report(
    page: str | Path,
    ledgers: Sequence[str | Path],
    catalogue: Sequence[str | Path],
    data: str | Path,
    fetched: Sequence[str | Path],
    clips: Sequence[str | Path],
    motions: Sequence[str | Path],
    origins: Sequence[str | Path],
    series: Mapping[str, str | Path],
    clusters: Mapping[str, str | Path],
    labels: str | Path,
    exemplars: str | Path,
    profiles: str | Path,
    intervals: Sequence[str | Path],
    frames: Sequence[str | Path],
    split: str | Path,
    duplicates: str | Path,
    descriptions: str | Path,
    attributes: str | Path,
    weights: str | Path,
    statistics: str | Path,
    annotation_metrics: str | Path,
    confusion: str | Path,
    labelling: str | Path,
    models: Sequence[str],
    checkpoints: Sequence[str | Path],
    metrics: Sequence[str | Path],
    generated: Sequence[str | Path],
    truth: str | Path | None,
    face: str | Path | None,
    annotate: Mapping[str, Any],
    overlap: float,
    side: str,
    sources: Mapping[str, Any],
    balance: float,
    options: Mapping[str, Any],
) -> None:
    """Write the page of a run: self-contained HTML, of which nothing in the tables becomes markup.

    ledgers, catalogue (all clips), fetched (clips with their videos), clips (kept), motions,
    intervals, frames: a table per shard. series, clusters: tables by region. labelling: the metrics
    of labels spent. checkpoints, metrics, generated: one per model. truth: of
    `read_truth`, perhaps with faults.csv, or None. face: what motion is drawn on, None for the
    embedded face. annotate: the limits of the annotation; overlap: of intervals that are right.
    side: the side of the face that was clustered. data, sources: the folder of sources and
    `stills`' options, how they are found there. balance: how far rare attributes are weighted up.
    options: title, clips (timelines drawn), exemplars (per cluster).
    A table that is empty shows its reason; a video or face that cannot be read is said and stood in
    for. Raises BadFile where the ledgers do not add up.
    """
    kept = tables.read_all(tables.CLIPS, clips)
    marked = tables.read_all(tables.FRAMES, frames)
    true = read_truth(truth, kept, tables.read_all(tables.LEDGER, ledgers)) if truth else None
    parts = tables.read(tables.SPLIT, split)
    part_of = dict(zip(parts["clip_id"], parts["part"], strict=True))
    fps = {clip.clip_id: float(clip.fps_num / clip.fps_den) for clip in kept.itertuples()}
    through = set(parts["clip_id"])
    way = funnel(ledgers, truth, through)
    videos = tables.read_all(tables.CLIPS, fetched)
    videos = videos[videos["media"].notna()]
    actor = stand_in(face)
    filmed = dict(zip(videos["clip_id"], videos["media"], strict=True))
    never_cut = {loss.clip_id for loss in way.losses} - filmed.keys()
    album = Album(filmed, motions, actor, stills(catalogue, data, never_cut, **sources))
    wanted = options["exemplars"]
    found = regions(series, clusters, labels, exemplars, profiles, fps, side, wanted, album)
    drawn = timelines(kept, intervals, marked, true, options["clips"], part_of, album)
    lengths = dict(zip(videos["clip_id"], videos["n_frames"], strict=True))
    why = evidence(way.losses, motions, lengths, album)
    cards = sheet(kept, marked, album)
    twins = pairs(duplicates, kept, part_of, album)
    told = captions(descriptions, kept, intervals, album)
    album.develop()
    scored = scores(annotation_metrics, marked, true)
    measured = channels(statistics, origins)
    trained = [
        model(name, checkpoint, scores_of)
        for name, checkpoint, scores_of in zip(models, checkpoints, metrics, strict=True)
    ]
    asked = [pictures(path, motions, marked, kept, side, GENERATED, actor) for path in generated]
    finished = kept[kept["clip_id"].isin(through)]
    owners = tables.read_all(tables.INTERVALS, intervals, ["clip_id"])["clip_id"]
    n_intervals = int(owners.isin(through).sum())
    facts = {
        "figures": figures(way, finished, n_intervals, scored, trained),
        "lead": lead(way, parts, found, scored.against),
        "missing": missing(way, measured, found, drawn, scored, trained, album, twins),
        "funnel": way,
        "evidence": why,
        "gauge_width": gauge.WIDTH,
        "sheet": shown(cards, album),
        "pairs": twins,
        "shows": shows(attributes, weights, balance),
        "captions": told,
        "album": album,
        "statuses": STATUSES,
        "channels": measured,
        "regions": found,
        "exemplar": {"width": WIDTH, "height": HEIGHT, "leaders": LEADERS, "gap": GAP},
        "timelines": drawn,
        "tracks": {track: track_actions(track) for track in TRACKS},
        "actions": list(ACTIONS),
        "scores": scored,
        "labelling": spent(labelling),
        "overlap": overlap,
        "matrices": matrices(confusion),
        "models": list(zip(trained, asked, strict=True)),
        "variant_words": VARIANT_WORDS,
        "limits": annotate,
        "side": side,
        "files": _files(
            names=Path(labels).with_name("labels.yaml"),
            labels=labels,
            decisions=ledgers[1:2],
            films=[Path(path).with_name("media") for path in fetched],
            clips=clips,
            motion=motions,
            intervals=intervals,
            frames=frames,
            descriptions=descriptions,
            weights=weights,
            duplicates=duplicates,
        ),
        "label_command": f"mimeline label --results {shlex.quote(str(Path(labels).parents[1]))}",
        "track_names": words.TRACK_NAMES,
    }
    size = write_page(page, "page.html.j2", options["title"], facts)
    log.info("%.1f MB, %d clips kept of %d", size / 1e6, way.kept, way.entered)


def _files(**places: str | Path | Sequence[str | Path]) -> dict[str, str]:
    """Where the tables lie, as the workflow names them; several shards as a pattern."""
    shown = {}
    for name, paths in places.items():
        if isinstance(paths, str | Path):
            shown[name] = str(paths)
            continue
        folders = sorted({str(Path(path).parent.parent / "*") for path in paths})
        shown[name] = ", ".join(str(Path(folder) / Path(paths[0]).name) for folder in folders)
    return shown
