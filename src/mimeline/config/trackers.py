"""Section `ingest`: a block per format of tracking results."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from mimeline.config.section import Count, Positive, Rate, Section, Share
from mimeline.vocabulary import CHANNELS

AngleUnit = Literal["radians", "degrees"]
OF_FACE_MODELS = ("metrical_tracker", "emoca", "flame", "bfm")  # formats of coefficients


class Results(Section):
    folder: str = Field(".", description="where the results lie, under data_dir")
    fps: Rate = Field(
        "30", description="frames per second of what was tracked, as 30 or 30000/1001"
    )


class OfFaceModel(Results):
    fps: Rate = Field("25", description="frames per second of what was tracked")
    face: str | None = Field(
        None,
        description="the face model's own file (FLAME's; BFM_model_front.mat), under data_dir, "
        "through which expressions become ARKit channels; null: they do not",
    )


class LiveLink(Results):
    """Live Link Face CSV."""

    folder: str = Field("livelink", description="where the results lie, under data_dir")
    timecode_base: Count = Field(60, description="frames per second that the timecode counts in")
    angle_unit: AngleUnit = Field("radians", description="unit of the head and eye columns")


class PyFeat(Results):
    """py-feat 2 tables."""

    fps: Rate = Field("25", description="frames per second of the videos that were analysed")
    stride: Count = Field(1, description="every n-th frame of the videos was analysed")


class MediaPipe(Results):
    """MediaPipe FaceLandmarker scores, CSV or JSON."""


class OpenFace(Results):
    """OpenFace 2 CSV."""


class MetricalTracker(OfFaceModel):
    """metrical-tracker: a folder of .frame files per clip."""


class Emoca(OfFaceModel):
    """EMOCA or DECA codes: a folder per clip."""


class Flame(OfFaceModel):
    """Sequences of FLAME coefficients, an npz file per clip."""


class Bfm(OfFaceModel):
    """Sequences of 257 coefficients of the Basel Face Model, a .mat file per clip."""


class Column(Section):
    """A column of a table, and what its numbers are multiplied with."""

    column: str = Field(description="name of the column")
    scale: float = Field(1.0, description="factor: -1 where the sign is the other way round")


class Table(Results):
    """Any table with a header, CSV or Parquet."""

    channels: dict[Literal[tuple(CHANNELS)], Column] = Field(
        {},
        description="channel: {column: its name, scale: a factor}; columns that bear a channel's "
        "own name need none",
    )
    angle_unit: AngleUnit = Field("radians", description="unit of head and gaze angles, scaled")
    frame: str | None = Field(None, description="column of frame numbers; null: row by row")
    first_frame: Annotated[int, Field(ge=0)] = Field(0, description="number of the first frame")
    valid: str | None = Field(None, description="column that is 0 where no face was found")
    confidence: str | None = Field(None, description="column of the tracker's confidence, 0-1")
    loss: str | None = Field(None, description="column of the tracker's loss")


class Ingest(Section):
    format: Literal[
        "livelink",
        "pyfeat",
        "mediapipe",
        "openface",
        "metrical_tracker",
        "emoca",
        "flame",
        "bfm",
        "table",
    ] = Field("livelink", description="which block to use")
    livelink: LiveLink = LiveLink()
    pyfeat: PyFeat = PyFeat()
    mediapipe: MediaPipe = MediaPipe()
    openface: OpenFace = OpenFace()
    metrical_tracker: MetricalTracker = MetricalTracker()
    emoca: Emoca = Emoca()
    flame: Flame = Flame()
    bfm: Bfm = Bfm()
    table: Table = Table()
    mirrored: bool = Field(
        False,
        description="the tracker saw mirrored pictures (a selfie camera's): sides are put right",
    )
    bad_values: Literal["fail", "mask"] = Field(
        "fail", description="text or NaN in a number's place: fail the clip, or mask the frame"
    )
    max_missing: Share = Field(0.1, description="largest share of frames without a face, else drop")
    max_loss: Positive | None = Field(
        None,
        description="largest tracking loss of a frame, in the tracker's own unit, else drop the "
        "clip (Höll 2024, 5.1, rule 4); null: no limit",
    )
    max_reprojection: Positive | None = Field(
        0.1,
        description="the same for a loss that is worked out from landmarks: their distance from "
        "the reprojected ones, in distances between the outer corners of the eyes; null: no limit",
    )

    @model_validator(mode="after")
    def _can_be_mirrored(self) -> "Ingest":
        if self.mirrored and self.format in OF_FACE_MODELS:
            raise ValueError(
                f"mirrored: false, since coefficients as of {self.format} have no sides"
            )
        return self
