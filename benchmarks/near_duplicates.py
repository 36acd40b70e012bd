"""How well films are known again, how strangers' are told apart, and how fast 70,000 clips are.

python benchmarks/near_duplicates.py FOLDER [FOLDER ...] [--same NAME ...] [--clips 70000]

FOLDER: videos of people; those of one person begin with the same letters up to the first of _.-
NAME: such beginnings that are one person, too.
Of each, copies are made: coded coarsely, scaled down, cropped, brightened, begun half a second
later, mirrored. Printed are the bits of 64 in which a copy's pictures differ from those of the same
second of the original, the shares of them within a limit, and the share of copies that are found
as near-duplicates by their pictures alone; the same of pictures of two people; the milliseconds
of one core per second of film; and then, with bits as these films have them, seconds and
memory for so many clips of eight pictures, one in a hundred of them a copy.
"""

import argparse
import re
import resource
import subprocess
import tempfile
import time
from itertools import combinations
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pandas as pd

from mimeline.dataset.alike_films import MOST_BITS, alike_films
from mimeline.media.fingerprint import BITS, MIRRORED, fingerprint

TARGET_S, TARGET_MB = 60, 1000
PICTURES = 8  # of a clip
SIZED = "scale=256:256"
COPIES = {  # ffmpeg's options before and after the input
    "original": ([], ["-crf", "18"]),
    "coded": ([], ["-crf", "38"]),
    "scaled": ([], ["-vf", "scale=128:-2", "-crf", "26"]),
    "cropped 5 %": ([], ["-vf", f"crop=iw*0.95:ih*0.95,{SIZED}"]),
    "cropped 10 %": ([], ["-vf", f"crop=iw*0.9:ih*0.9:iw*0.03:ih*0.07,{SIZED}"]),
    "brightened": ([], ["-vf", "eq=brightness=0.1:contrast=0.85:gamma=1.15"]),
    "half a second later": (["-ss", "0.5"], []),
    "mirrored": ([], ["-vf", "hflip"]),
}
LIMITS = (4, 6, 8, 10, 12)


def copied(source: Path, target: Path, before: list[str], after: list[str]) -> Path:
    """The first ten seconds at 30 frames per second with a key frame in each, as clips are cut."""
    made = ["-an", "-t", "10", "-r", "30", "-g", "30", "-c:v", "libx264", "-preset", "veryfast"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", "-threads", "1"]
    command += [*before, "-i", str(source), *made, *after, str(target)]
    subprocess.run(command, check=True)
    return target


def differing(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Bits in which words differ."""
    return np.bitwise_count((one ^ other).view(np.uint64))


def found(films: dict[str, dict[int, np.int64]]) -> set[tuple[str, str]]:
    """Pairs of films, second → word each, of which more than half is alike."""
    rows = [(name, 30 * second, word) for name, of in films.items() for second, word in of.items()]
    table = pd.DataFrame(rows, columns=["clip_id", "frame", "bits"])
    pairs = alike_films(table, pd.Series(30.0, list(films)), pd.Series(films.keys(), films), 0.5)
    return set(zip(pairs["clip_id"], pairs["other_id"], strict=True))


def shown(title: str, distances: np.ndarray, share: float) -> None:
    shares = "  ".join(f"{limit}: {np.mean(distances <= limit):.4f}" for limit in LIMITS)
    least, median, most = np.percentile(distances, [0, 50, 100])
    bits = f"{least:3.0f} {median:3.0f} {most:3.0f}"
    print(f"{title:22} {len(distances):6}  {bits}   {shares}   {share:.2f}")


def knowing_again(videos: list[Path], scratch: Path, same_names: list[str]) -> np.ndarray:
    """Prints the distances; returns the originals' words."""
    words: dict[Path, dict[str, dict[int, np.int64]]] = {}
    spent, seconds = 0.0, 0
    for video in videos:
        words[video] = {}
        for name, (before, after) in COPIES.items():
            film = copied(video, scratch / "copy.mp4", before, after)
            start = time.process_time()
            frames, bits = fingerprint(film)
            spent, seconds = spent + time.process_time() - start, seconds + len(frames)
            words[video][name] = dict(zip((frames // 30).tolist(), bits, strict=True))
    print("bits that differ       pairs  least median most   share within a limit, and pairs found")
    for name in list(COPIES)[1:]:
        turned = MIRRORED if name == "mirrored" else np.int64(0)
        same = [
            (of["original"][second], of[name][second] ^ turned)
            for of in words.values()
            for second in of["original"].keys() & of[name].keys()
        ]
        both = {f"{v.name} {n}": of[n] for v, of in words.items() for n in ("original", name)}
        pairs = found(both)
        n_found = sum(
            (f"{v.name} {name}", f"{v.name} original") in pairs
            or (f"{v.name} original", f"{v.name} {name}") in pairs
            for v in words
        )
        shown(name, differing(*np.array(same).T), n_found / len(words))
    original = {v: np.array(list(of["original"].values()), np.int64) for v, of in words.items()}
    pairs = found({video.name: of["original"] for video, of in words.items()})
    for same, title in ((True, "one person, two takes"), (False, "two people")):
        chosen = [
            (one, other)
            for one, other in combinations(original, 2)
            if (person_of(one, same_names) == person_of(other, same_names)) == same
        ]
        if chosen:
            apart = [
                differing(original[one][:, None], original[other][None]).ravel()
                for one, other in chosen
            ]
            n_found = sum(
                (one.name, other.name) in pairs or (other.name, one.name) in pairs
                for one, other in chosen
            )
            shown(title, np.concatenate(apart), n_found / len(chosen))
    print(f"{1000 * spent / seconds:.1f} ms of one core per second of film")
    return np.concatenate(list(original.values()))


def person_of(video: Path, same_names: list[str]) -> str:
    name = re.split(r"[_.\-]", video.name)[0]
    return same_names[0] if name in same_names else name


def made_up(like: np.ndarray, n_clips: int) -> pd.DataFrame:
    """Fingerprints of clips whose bits are as often set; one in a hundred repeats another."""
    rng = np.random.default_rng(0)
    often = ((like.view(np.uint64)[:, None] >> np.arange(BITS, dtype=np.uint64)) & 1).mean(axis=0)
    scenes = rng.random((n_clips, BITS)) < often
    bits = np.repeat(scenes, PICTURES, axis=0) ^ (rng.random((n_clips * PICTURES, BITS)) < 0.04)
    words = np.packbits(bits, axis=1, bitorder="little").view("<i8")[:, 0]
    copies = n_clips // 100 * PICTURES
    words[:copies] = words[len(words) - copies :]
    names = np.repeat([f"clip_{n:06}" for n in range(n_clips)], PICTURES)
    frames = np.tile(np.arange(PICTURES) * 30, n_clips)
    return pd.DataFrame({"clip_id": names, "frame": frames, "bits": words})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--same", nargs="*", default=[])
    parser.add_argument("--clips", type=int, default=70_000)
    options = parser.parse_args()
    endings = {".mp4", ".mov"}
    videos = [p for f in options.folders for p in sorted(f.iterdir()) if p.suffix in endings]
    with tempfile.TemporaryDirectory() as scratch:
        words = knowing_again(videos, Path(scratch), options.same)
    few = made_up(words, 100)
    names = pd.Index(few["clip_id"].unique())
    alike_films(few, pd.Series(30.0, names), pd.Series(names, names), 0.5)  # compiled
    table = made_up(words, options.clips)
    names = pd.Index(table["clip_id"].unique())
    start = time.perf_counter()
    pairs = alike_films(table, pd.Series(30.0, names), pd.Series(names, names), 0.5)
    spent = time.perf_counter() - start
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{options.clips} clips of {PICTURES} pictures, limit {MOST_BITS} bits: {len(pairs)} pairs"
    )
    print(f"{spent:.1f} s (target {TARGET_S}), {memory:.0f} MB at most (target {TARGET_MB})")


if __name__ == "__main__":
    main()
