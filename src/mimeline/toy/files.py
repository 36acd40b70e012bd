"""The world in the real file formats, and the truth in a folder of its own."""

import json
import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.progress import told
from mimeline.toy import faults, frame_files, livelink, plan, video
from mimeline.toy.appearance import appearance
from mimeline.toy.faults import Fault
from mimeline.toy.plan import Person, PlannedClip
from mimeline.toy.world import World, render
from mimeline.vocabulary import HEAD

log = logging.getLogger(__name__)

POSE_JITTER_DEG = 0.8  # the pose network's own
FAULTLESS = Fault("", "", "kept")  # a clip that nothing is wrong with
SAID = {  # what a catalogue calls an action
    "Smile": "smile",
    "SoftSmile": "smile",
    "MouthFrown": "frown",
    "BrowDown": "frown",
    "EyeSquint": "squint",
    "EyeClose": "blink",
    "GazeLeft": "look_around",
    "GazeRight": "look_around",
    "HeadDown": "nod",
}


def make(
    data: Path,
    truth: Path,
    people: int,
    clips: int,
    seed: int,
    video_share: float,
    video_px: int,
    tracker: str = "livelink",
    smiles_frown: float = 0.0,
) -> None:
    """Write a world with faults: data as it would be published, truth for the evaluation alone.

    One clip more is listed than there are: a sound one a second time, under another name.
    data: celebvtext_info.json, annotations.json, livelink/<clip_id>.csv, head_pose.csv,
    videos/<clip_id>.mp4; with tracker "metrical_tracker" in place of the CSV files
    metrical_tracker/<clip_id>/checkpoint/<frame>.frame and face_model.npz. truth: frames.parquet,
    intervals.parquet, faults.csv.
    video_share: how many of the clips have a video; those with a fault that is to be seen have
    one too, but 0 makes none. video_px: edge of the picture. smiles_frown: as for `simulate`.
    Deterministic in the seed.
    """
    crowd = plan.people(people, seed)
    rng = np.random.default_rng([seed, 5])
    planned, planted = plan.clips(clips, crowd, seed), faults.spread(clips, rng, video_share > 0)
    planned = [planted[i].planned(c) if i in planted else c for i, c in enumerate(planned)]
    world = render(planned, crowd, seed, smiles_frown)
    (data / tracker).mkdir(parents=True, exist_ok=True)
    truth.mkdir(parents=True, exist_ok=True)
    faulty = {planned[position].clip_id: fault for position, fault in planted.items()}
    again = _again(planned, faulty)
    _write_json(data / "celebvtext_info.json", _info(planned) | again)
    _write_json(data / "annotations.json", _annotations(world))
    tracked = _takes(data / tracker, world, faulty, rng)
    if tracker == frame_files.FOLDER:
        frame_files.write_face(data / frame_files.FACE)
    if video_share > 0:
        _videos(data / "videos", world, faulty, tracked, crowd, seed, video_share, video_px)
    _head_pose(_visible(world), rng).to_csv(
        data / "head_pose.csv", index=False, float_format="%.4f", lineterminator="\n"
    )
    tables.write(tables.FRAMES, _inside(world.frames), truth / "frames.parquet")
    tables.write(tables.INTERVALS, _inside(world.intervals), truth / "intervals.parquet")
    listed = [(clip_id, f.name, f.stage, f.status) for clip_id, f in faulty.items()]
    listed += [(key.removesuffix(".mp4"), "listed_twice", "select", "dropped") for key in again]
    pd.DataFrame(listed, columns=["clip_id", "fault", "stage", "status"]).to_csv(
        truth / "faults.csv", index=False, lineterminator="\n"
    )


def _takes(
    folder: Path, world: World, faulty: dict[str, Fault], rng: np.random.Generator
) -> dict[str, np.ndarray]:
    """Write the tracking results. Returns for each clip which frames they have, (n_frames,)."""
    motion, tracked = dict(iter(world.motion.groupby("clip_id"))), {}
    for clip in world.clips:
        fault = faulty.get(clip.clip_id, FAULTLESS)
        if clip.clip_id == faults.OUTSIDE or fault.written is None:
            continue
        lines = livelink.lines(motion[clip.clip_id], start=livelink.timecode_start(rng))
        written = fault.written(lines, rng)
        tracked[clip.clip_id] = np.isin(lines[1:], written)
        if folder.name == frame_files.FOLDER:
            place = folder / clip.clip_id
            frame_files.write_takes(place, motion[clip.clip_id], tracked[clip.clip_id])
            fault.framed(place, tracked[clip.clip_id])
            continue
        path = folder / f"{clip.clip_id}.csv"
        path.write_text("\n".join(written) + "\n", encoding="utf-8", newline="")
    return tracked


def _videos(
    folder: Path,
    world: World,
    faulty: dict[str, Fault],
    tracked: dict[str, np.ndarray],
    crowd: Sequence[Person],
    seed: int,
    share: float,
    size: int,
) -> None:
    """Write the videos of the clips whose turn it is, and of those whose fault is to be seen."""
    folder.mkdir(parents=True, exist_ok=True)
    clean = dict(iter(world.clean.groupby("clip_id")))
    numbers = {person.name: number for number, person in enumerate(crowd)}
    faults_of = {clip.clip_id: faulty.get(clip.clip_id, FAULTLESS) for clip in world.clips}
    filmed = [
        clip
        for clip in world.clips
        if not (fault := faults_of[clip.clip_id]).ends_early
        and (fault.needs_video or video.has_turn(clip.index, share))
    ]
    for clip in told(filmed, "videos", log):
        fault = faults_of[clip.clip_id]
        path = folder / f"{clip.clip_id}.mp4"
        none = np.zeros(clip.n_frames, dtype=bool)
        video.shoot(
            path,
            clip,
            looks=appearance(numbers[clip.person], seed),
            motion=clean[clip.clip_id],
            speech=world.speech[clip.clip_id],
            covered=~tracked[clip.clip_id] if fault.covered else none,
            shown=fault.shown(clip.n_frames, np.random.default_rng([seed, 9, clip.index])),
            size=size,
            seed=seed,
        )
        path.write_bytes(fault.stored(path.read_bytes()))


def _visible(world: World) -> pd.DataFrame:
    """The motion of the clips in which somebody is to be seen."""
    empty = [clip.clip_id for clip in world.clips if clip.deserted]
    return world.motion[~world.motion["clip_id"].isin(empty)]


def _inside(rows: pd.DataFrame) -> pd.DataFrame:
    """Without the hostile clip, of which nothing but the catalogue knows."""
    return rows[rows["clip_id"] != faults.OUTSIDE]


def _info(clips: Sequence[PlannedClip]) -> dict:
    return {
        f"{clip.clip_id}.mp4": {
            "ytb_id": clip.source,
            "meta_video_names": clip.clip_id.rsplit("_", 1)[0],
            "subject": clip.person,
            "duration": {"start_sec": round(_start(clip), 2), "end_sec": round(_end(clip), 2)},
            "bbox": dict(zip(("top", "bottom", "left", "right"), clip.bbox, strict=True)),
            "version": "v0.11",
        }
        for clip in clips
    }


def _again(clips: Sequence[PlannedClip], faulty: dict[str, Fault]) -> dict:
    """The record of a clip that nothing is wrong with, a second time under another name."""
    sound = [clip for clip in clips if clip.clip_id not in faulty][:1]
    return {f"{key.removesuffix('_0.mp4')}_1.mp4": again for key, again in _info(sound).items()}


def _start(clip: PlannedClip) -> float:
    return clip.start_frame / clip.fps


def _end(clip: PlannedClip) -> float:
    return (clip.start_frame + clip.n_frames) / clip.fps


def _annotations(world: World) -> dict:
    """Whole seconds of the source video; what begins in the same second bears the same order."""
    said = world.intervals.assign(said=world.intervals["action"].map(SAID)).dropna(subset="said")
    by_clip = dict(iter(said.groupby("clip_id")))
    records = {}
    for clip in world.clips:
        throughout = (*clip.catalogue_actions, *(["talk"] if clip.talks else []))
        spans = {(name, int(_start(clip)), int(_end(clip))) for name in throughout}
        for row in by_clip.get(clip.clip_id, said[:0]).itertuples():
            first = (clip.start_frame + row.start_frame) // clip.fps
            last = max(first + 1, (clip.start_frame + row.end_frame) // clip.fps)
            spans.add((row.said, first, last))
        ordered = sorted(spans, key=lambda span: (span[1], span[0], span[2]))
        order = {second: place for place, second in enumerate(sorted({s[1] for s in spans}))}
        records[clip.clip_id] = [
            [name, [_clock(first, clip), _clock(last, clip), last - first, order[first]]]
            for name, first, last in ordered
        ]
    return {"act": records, "app": {}}


def _clock(second: int, clip: PlannedClip) -> str:
    """h:mm:ss, in some clips without the zeros in front, as the published file has it."""
    hours, minutes, seconds = second // 3600, second // 60 % 60, second % 60
    padded = clip.index % 3 > 0
    return f"{hours}:{minutes:02d}:{seconds:02d}" if padded else f"{hours}:{minutes}:{seconds}"


def _head_pose(motion: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """6DRepNet's degrees and signs: +yaw to the subject's right, +pitch up, +roll to the left."""
    motion = _inside(motion)
    degrees = np.degrees(motion[list(HEAD)].to_numpy(float))  # (n, 3) yaw left, pitch up, tilt left
    degrees += rng.normal(scale=POSE_JITTER_DEG, size=degrees.shape)
    pose = motion[["clip_id", "frame"]].reset_index(drop=True)
    return pose.assign(pitch=degrees[:, 1], yaw=-degrees[:, 0], roll=degrees[:, 2])


def _write_json(path: Path, content: dict) -> None:
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8", newline="")
