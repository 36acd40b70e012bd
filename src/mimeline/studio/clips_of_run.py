"""The clips of a run for a page: what they are, what became of them, where their films lie."""

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.clips.description.stretches import is_untimed
from mimeline.clips.media_of_run import KINDS, files_of
from mimeline.errors import NoSuchFile
from mimeline.reporting import words
from mimeline.reporting.funnel import STAGES


class ClipsOfRun:
    """The clips that the catalogue handed on, each as the last stage that knew it left it.

    results: a run's results, of any stages from `catalogue` on; records that the catalogue refused
    are no clips. Raises NoSuchFile where there is no run, BadFile for a table that cannot be read.
    """

    def __init__(self, results: str | Path):
        self.results = Path(results)
        if not any(self.results.glob("catalogue/*/clips.parquet")):
            raise NoSuchFile(
                self.results,
                found="no clips of a run",
                expected="the results of a run, catalogue/*/clips.parquet among them",
                remedy="Run `snakemake --cores 2 --until fetch`, or name the folder of another "
                "run with --results.",
            )
        parts = [self._clips(stage) for stage in STAGES]
        clips = pd.concat([part for part in parts if len(part)] or parts[:1])
        clips = clips.drop_duplicates("clip_id", keep="last").sort_values("clip_id")
        self.clips = clips.set_index("clip_id", drop=False)
        self.media = {kind: files_of(self.results, kind) for kind in KINDS}
        self._ledger = self._decisions()
        self._rows_of = self._ledger.groupby("clip_id").indices

    def __contains__(self, clip_id: str) -> bool:
        return clip_id in self.clips.index

    def listing(self) -> dict[str, list]:
        """Columns of one entry per clip: id, status, why it is lost, whether it has a film."""
        lost = self._ledger[self._ledger["status"] != "kept"].drop_duplicates("clip_id")
        lost = lost.set_index("clip_id").reindex(self.clips.index)
        length_s = self.clips["end_s"] - self.clips["start_s"]
        return {
            "id": self.clips.index.tolist(),
            "status": lost["status"].fillna("kept").tolist(),
            "why": [None if pd.isna(s) else words.rule(r) for s, r in _pairs(lost)],
            "film": self.clips.index.isin(list(self.media["film"])).tolist(),
            "length_s": length_s.round(2).tolist(),
        }

    def facts(self, clip_id: str) -> dict:
        """What the page tells of a clip, in words; times in seconds from the clip's start."""
        clip = self.clips.loc[clip_id]
        ledger = [_told(row) for row in self._until_lost(clip_id)]
        return {
            "id": clip_id,
            "facts": [[name, text] for name, text in _facts(clip) if text],
            "texts": [text for text in clip["texts"] if text],
            "length_s": float(clip["end_s"] - clip["start_s"]),
            "fps": _rate(clip),
            "tracks": _tracks(clip, "actions", "action") + _tracks(clip, "emotions", "emotion"),
            "ledger": ledger,
            "film": clip_id in self.media["film"],
            "sound": clip_id in self.media["sound"],
            "no_film": "" if clip_id in self.media["film"] else _no_film(ledger),
        }

    def _clips(self, stage: str) -> pd.DataFrame:
        paths = sorted(self.results.glob(f"{stage}/*/clips.parquet"))
        return tables.read_all(tables.CLIPS, paths)

    def _decisions(self) -> pd.DataFrame:
        """The ledgers' rows on the clips, in the order of stages; none after the one that lost it.

        A stage that is older than the one before it may know clips that did not come to it.
        """
        paths = [*self.results.glob("*/ledger.parquet"), *self.results.glob("*/*/ledger.parquet")]
        rows = tables.read_all(tables.LEDGER, paths)
        rows = rows[rows["clip_id"].isin(self.clips.index) & rows["stage"].isin(STAGES)]
        places = rows["stage"].map({stage: place for place, stage in enumerate(STAGES)})
        return rows.iloc[places.argsort(kind="stable")].reset_index(drop=True)

    def _until_lost(self, clip_id: str) -> Iterable:
        for row in self._ledger.iloc[self._rows_of.get(clip_id, [])].itertuples():
            yield row
            if row.status != "kept":
                return


def _pairs(lost: pd.DataFrame) -> Iterable[tuple]:
    return zip(lost["status"], lost["rule"], strict=True)


def _told(row) -> dict:
    """A ledger's row in words; frames: the first and last that broke the rule, or None."""
    rule, detail = _text(row.rule), _text(row.detail)
    rule = words.rule(rule) if rule else ""
    if detail.startswith(words.NOT_APPLIED):
        rule, detail = f"rule “{rule}” was {detail}", ""
    measured = words.measure(row.value, row.unit)
    if row.status != "kept" and measured and (limit := words.measure(row.limit, row.unit)):
        measured = f"{measured}, limit {limit}"
    frames = None
    if pd.notna(row.first_frame):
        last = row.first_frame if pd.isna(row.last_frame) else row.last_frame
        frames = [int(row.first_frame), int(last)]
    return {
        "stage": row.stage,
        "status": row.status,
        "rule": rule,
        "measured": measured,
        "frames": frames,
        "detail": detail,
    }


def _facts(clip: pd.Series) -> Iterable[tuple[str, str]]:
    yield "Source", clip["source_id"]
    yield "Person", _text(clip["subject_id"])
    yield "In the source", f"{clip['start_s']:.2f}–{clip['end_s']:.2f} s"
    yield "Length", f"{clip['end_s'] - clip['start_s']:.2f} s"
    if fps := _rate(clip):
        yield "Frames", f"{clip['n_frames']} at {fps:g} fps"
    if pd.notna(clip["width"]) and pd.notna(clip["height"]):
        yield "Size", f"{clip['width']} × {clip['height']} px"
    yield "Emotion", _text(clip["emotion"])
    spans = [*clip["actions"], *clip["emotions"]]
    sometime = [span["name"] for span in spans if _untimed(clip, span)]
    yield "At some time", ", ".join(name.replace("_", " ") for name in sometime)
    yield "Attributes", ", ".join(name.replace("_", " ") for name in clip["attributes"])


def _rate(clip: pd.Series) -> float | None:
    known = all(pd.notna(clip[name]) for name in ("fps_num", "fps_den", "n_frames"))
    return float(clip["fps_num"] / clip["fps_den"]) if known else None


def _untimed(clip: pd.Series, span: dict) -> bool:
    return is_untimed(span, clip["end_s"] - clip["start_s"])


def _tracks(clip: pd.Series, column: str, kind: str) -> list[dict]:
    """A track per name, in the order in which they begin; uncertainty of an edge in seconds."""
    tracks: dict[str, list] = {}
    timed = [span for span in clip[column] if not _untimed(clip, span)]
    for span in sorted(timed, key=lambda span: (span["start_s"], span["name"])):
        unsure = span["uncertainty_s"]
        edges = [span["start_s"], span["end_s"], 0.0 if pd.isna(unsure) else unsure]
        tracks.setdefault(span["name"], []).append(edges)
    return [
        {"name": name.replace("_", " "), "kind": kind, "spans": spans}
        for name, spans in tracks.items()
    ]


def _text(value) -> str:
    return "" if pd.isna(value) else str(value)


def _no_film(ledger: list[dict]) -> str:
    """Why a clip has no film, from what was decided on it."""
    last = ledger[-1] if ledger else None
    if last and last["status"] != "kept" and last["stage"] in ("catalogue", "select"):
        return f"It was {last['status']} before films are cut: {last['rule']}."
    at_fetch = next((row for row in ledger if row["stage"] == "fetch"), None)
    if at_fetch is None:
        return "Its film is not cut yet: run `snakemake --until fetch`."
    if at_fetch["status"] != "kept":
        return f"Its film could not be made: {at_fetch['rule']}."
    return "It has tracking alone: no video of it was found."
