"""What to do about a clip that a stage dropped or failed."""

import math

AGAIN = "then type snakemake --cores 2 again"
FORCED = "snakemake --cores 2 --forcerun {stage}"
# The key whose limit a clip broke, by stage and rule.
KEYS: dict[tuple[str, str], str] = {
    ("select", "too_short"): "select.min_s",
    ("select", "too_long"): "select.max_s",
    ("select", "too_small"): "select.min_side_px",
    ("select", "duplicate"): "select.max_overlap",
    ("fetch", "too_large"): "fetch.max_pixels",
    ("fetch", "too_many_bytes"): "fetch.max_mb",
    ("fetch", "too_long_source"): "fetch.max_source_s",
    ("fetch", "timed_out"): "fetch.timeout_s",
    ("ingest", "tracking_lost"): "ingest.max_missing",
    ("pose", "turned"): "pose.max_yaw_deg",
}
ASKABLE = ("select.", "pose.max_yaw_deg")  # what `mimeline funnel --set` can tell of
REMEDIES: dict[str, str] = {
    "excluded": "Take its line out of the list that select.exclusions names",
    "excluded_action": "Take the action out of select.excluded_actions",
    "condition": "Change select.conditions",
    "unsafe_id": "Give it a plain file name in the catalogue",
    "repeated_id": "Give each record an id of its own, if it is a clip of its own",
    "case_collision": "Rename one of the two: some disks hold them for one file",
    "bad_times": "Mend its times in the catalogue",
    "box_outside": "Mend its box in the catalogue",
    "unsafe_path": "Name a video under data_dir",
    "gone": "Where you have a copy of the video, put it into fetch.folder",
    "not_downloaded": "Install what downloads videos: pip install 'mimeline[download]'",
    "unreachable": "The site did not answer: run the stage again later",
    "no_tracking_result": "Put its tracking result into the tracker's folder, under its clip_id",
    "tracking_loss": "Track it again, or raise ingest.max_loss or ingest.max_reprojection",
    "split_gap": "Lower split.gap_s, or add sources: with three and more there is no gap",
    "near_duplicate": "It repeats a clip of another part; split.near_duplicates: null keeps it",
}
FORCING = ("unreachable", "not_downloaded", "gone")
ELSE = "Do what it says"


def remedy(stage: str, rule: str, value: float | None, config: str = "config/config.yaml") -> str:
    """What to do, in a sentence or two. value: what the clip has, where the ledger knows."""
    key = KEYS.get((stage, rule))
    if key == "select.max_overlap":
        return f"Set {key} to 1 or to null in {config}, {AGAIN}."
    if key and value is not None and math.isfinite(value):
        least = _beyond(value, down=key.startswith("select.min"))
        told = f"Set {key} to {least} in {config}, {AGAIN}."
        if key.startswith(ASKABLE):
            told += f" What else that keeps: mimeline funnel --set {key}={least}"
        return told
    if key:
        return f"Change {key} in {config}, {AGAIN}."
    do = REMEDIES.get(rule, ELSE)
    return f"{do}: {FORCED.format(stage=stage)}" if rule in FORCING else f"{do}, {AGAIN}."


def _beyond(value: float, down: bool) -> str:
    """A limit of few digits that the value does not break."""
    scale = 10.0 if value >= 10 else 1000.0
    return f"{(math.floor if down else math.ceil)(round(value * scale, 6)) / scale:.10g}"
