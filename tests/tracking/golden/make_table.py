"""Golden tables of a tracker nobody knows: foreign names, per cent, degrees, signs the other way.

`table/options.yaml` holds the mapping. The columns mean what their names say: yaw_right is positive
toward the subject's right, pitch_down is positive downward, lean is positive toward the left
shoulder, blink_l and blink_r are per cent of a closed lid, eyes_x is positive to the subject's
right and eyes_y is positive up. Frames count from 1; ok is 1 where a face was found.
"""

from pathlib import Path

DEGREES, PER_CENT = 17, 90
COLUMNS = ("yaw_right", "pitch_down", "lean", "blink_l", "blink_r", "eyes_x", "eyes_y")
MOVES = {
    "turns_left": ("yaw_right", -DEGREES),
    "turns_right": ("yaw_right", DEGREES),
    "lifts_head": ("pitch_down", -DEGREES),
    "tilts_left": ("lean", DEGREES),
    "tilts_right": ("lean", -DEGREES),
    "looks_left": ("eyes_x", -DEGREES),
    "looks_right": ("eyes_x", DEGREES),
    "looks_up": ("eyes_y", DEGREES),
    "closes_left_eye": ("blink_l", PER_CENT),
    "closes_right_eye": ("blink_r", PER_CENT),
}

if __name__ == "__main__":
    for move, (moving, largest) in MOVES.items():
        rows = [",".join(["number", "ok", *COLUMNS])]
        for step in range(5):
            rest = {"blink_l": 2.0, "blink_r": 2.0}
            told = [
                largest * step / 4 if name == moving and step else rest.get(name, 0.0)
                for name in COLUMNS
            ]
            rows.append(",".join(f"{cell:g}" for cell in (step + 1, 1, *told)))
        path = Path(__file__).parent / "table" / f"{move}.csv"
        path.write_text("\n".join(rows) + "\n")
