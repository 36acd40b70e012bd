"""How a catalogue of clips is given: one block per format."""

import re
from pathlib import PurePosixPath
from typing import Annotated, Literal

from pydantic import Field, model_validator

from mimeline.config.section import Positive, Section


class CelebvText(Section):
    """A catalogue as CelebV-Text publishes it."""

    info: str = Field("celebvtext_info.json", description="clips: file under data_dir")
    annotations: str | None = Field(
        "annotations.json",
        description="actions and appearances: annotations.pkl or JSON under data_dir, or null",
    )
    texts: list[str] = Field(
        [], description="folders of published descriptions, <clip>.txt, under data_dir"
    )


class Files(Section):
    """Every file of the tracker's folder is a take."""

    pattern: Annotated[str, Field(pattern=r"^[^/]+$")] = Field(
        "*", description="which of the tracker's files, or of its folders, are takes"
    )
    exclude: list[str] = Field([], description="file names to leave out (tables of attributes)")
    subject: str | None = Field(
        None, description="the person of all takes; null: nobody is known, each take stands alone"
    )
    subject_pattern: str | None = Field(
        None,
        description="regular expression: what it finds in a take's name is its person; null: "
        "names tell nobody",
    )

    @model_validator(mode="after")
    def _tells_people_once(self) -> "Files":
        if self.subject is not None and self.subject_pattern is not None:
            raise ValueError("subject or subject_pattern, not both")
        try:
            re.compile(self.subject_pattern or "")
        except re.error as error:
            raise ValueError(f"subject_pattern to be a regular expression ({error})") from None
        return self


class Videos(Section):
    """Every video of a folder is a source; nothing else is known of it."""

    folder: str = Field(".", description="where the videos lie, under data_dir")
    pattern: Annotated[str, Field(pattern=r"^[^/]")] = Field(
        "*",
        description="which files of the folder are looked at; */* for those a folder further down, "
        "**/* for all below",
    )
    exclude: list[str] = Field([], description="file names to leave out")
    subject: str | None = Field(
        None, description="the person of all videos; null: nobody is known, each video stands alone"
    )

    @model_validator(mode="after")
    def _stays_below(self) -> "Videos":
        parts = PurePosixPath(self.pattern).parts
        if not parts or ".." in parts or any("**" in part and part != "**" for part in parts):
            raise ValueError("pattern as *.mp4, */*.mp4 or **/*.mp4, without ..")
        return self


class CelebvHq(Section):
    """A catalogue as CelebV-HQ publishes it."""

    info: str = Field("celebvhq_info.json", description="clips: file under data_dir")


class RealTalk(Section):
    """Videos of two people: p0 on the picture's left, p1 on its right."""

    folder: str = Field("videos", description="where the videos lie, under data_dir")
    annotations: str | None = Field(
        "metadata",
        description="folder of <video>.json, under data_dir: faces and who speaks; null, or where "
        "there is none: each person is half of the picture",
    )
    margin: float = Field(
        0.5, ge=0, le=4, description="how far a box reaches beyond the faces in it, in faces"
    )


View = Literal["front", "down", "top", "left_30", "left_60", "right_30", "right_60"]


class Mead(Section):
    """MEAD's folders: person / video / view / emotion / level / take."""

    folder: str = Field(".", description="where the people's folders lie, under data_dir")
    views: list[View] = Field(["front"], min_length=1, description="cameras to take")


class Ravdess(Section):
    """RAVDESS's files: what is shown stands in their names."""

    folder: str = Field(
        ".", description="where the files or the actors' folders lie, under data_dir"
    )


class ClipTable(Section):
    """A table with a row per clip."""

    file: str = Field(
        "clips.csv",
        description="CSV or Parquet, under data_dir; docs/catalogues.md has its columns",
    )


class Catalogue(Section):
    format: Literal[
        "celebvtext", "celebvhq", "realtalk", "mead", "ravdess", "table", "files", "videos"
    ] = Field("celebvtext", description="which block to use")
    celebvtext: CelebvText = CelebvText()
    celebvhq: CelebvHq = CelebvHq()
    realtalk: RealTalk = RealTalk()
    mead: Mead = Mead()
    ravdess: Ravdess = Ravdess()
    table: ClipTable = ClipTable()
    files: Files = Files()
    videos: Videos = Videos()
    cut_s: Positive | None = Field(
        None, description="cut longer takes into consecutive clips of that many seconds; null: no"
    )
