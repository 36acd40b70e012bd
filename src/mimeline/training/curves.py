"""A training's curves as TensorBoard reads them."""

from collections.abc import Sequence
from pathlib import Path

NAMES = ("loss", "val_loss", "learning_rate", "gradient_norm")
Row = Sequence[float | None]


class Curves:
    """An event file in the folder, in the place of older ones.

    Each row is on the disk when `add` returns; there is no thread that could lose an error.
    start: when the training began, seconds since 1970.
    """

    def __init__(self, folder: str | Path, start: float):
        from tensorboardX.event_file_writer import EventsWriter  # only a training needs it

        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob("events.out.tfevents.*"):
            old.unlink()
        self.start = start
        self.writer = EventsWriter(str(folder / "events"))

    def add(self, row: Row, before: Row | None) -> None:
        """A row of the losses, columns as the journal's; before: the one before it, if any."""
        from tensorboardX.proto.event_pb2 import Event

        step, *values, seconds = row
        past_step, past_s = (before[0], before[-1]) if before else (0, 0.0)
        points = dict(zip(NAMES, values, strict=True))
        points["steps_per_second"] = (step - past_step) / max(seconds - past_s, 1e-9)
        for name, value in points.items():
            if value is not None:
                event = Event(wall_time=self.start + seconds, step=step)
                event.summary.value.add(tag=name, simple_value=value)
                self.writer.write_event(event)
        self.writer.flush()
