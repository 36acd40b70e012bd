"""What becomes of clips before they are annotated, and what is said of them after."""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from mimeline.config.section import Count, Positive, Rate, Section, Seed, Share


class Select(Section):
    min_s: float = Field(5.0, ge=0, description="shortest clip, seconds (Höll 2024, 5.1)")
    max_s: Positive = Field(10.0, description="longest clip, seconds (Höll 2024, 5.1)")
    min_side_px: Count = Field(512, description="least width and height of the face crop, pixels")
    excluded_actions: list[str] = Field(
        ["turn", "shake_head", "head_wagging"],
        description="catalogue actions that drop a clip (Höll 2024, 5.1)",
    )
    conditions: list[str] = Field(
        [],
        description="what else a kept clip fulfils, over the columns of docs/selection.md, such as "
        "\"emotion == 'happy'\"",
    )
    max_overlap: Share | None = Field(
        0.5,
        description="of two clips of one source that share more than that of the shorter one's "
        "time and of the smaller box, the first is kept; null: both",
    )
    exclusions: str | None = Field(
        None, description="CSV with clip_id and reason: clips left out by hand; null: none"
    )


class Fetch(Section):
    """The clips' videos: cut, cropped, at a constant rate."""

    folder: str | None = Field(
        "videos",
        description="where <clip_id>.mp4 or the sources' <source_id>.mp4 lie, under data_dir; "
        "null: there are none",
    )
    url: str | None = Field(
        None,
        description="address of a source that does not lie there, as "
        "https://www.youtube.com/watch?v={source_id}; null: nothing is downloaded",
    )
    max_height: Count = Field(1080, description="tallest picture to ask a site for, pixels")
    attempts: Count = Field(
        3, description="how often a download that may succeed is tried in one run"
    )
    stall_s: Positive = Field(
        30.0, description="a download that brings nothing for so long has failed, seconds"
    )
    keep_sources: bool = Field(
        False, description="whether downloaded videos stay after their clips are cut"
    )
    fps: Rate | None = Field(
        None, description="frames per second to cut to; null: the tracking results' own"
    )
    side_px: Annotated[int, Field(ge=16, multiple_of=2)] | None = Field(
        None, description="edge of the square picture to scale to, pixels; null: as cropped"
    )
    max_pixels: Count = Field(
        33_177_600, description="largest picture, width x height (8K: 33177600)"
    )
    max_source_s: Positive = Field(14_400.0, description="longest source video, seconds")
    max_mb: Positive = Field(
        8_000.0, description="largest source video, and largest film made of one, megabytes"
    )
    timeout_s: Positive = Field(
        300.0, description="longest single run of a probe or of ffmpeg on a video, seconds"
    )

    @field_validator("url")
    @classmethod
    def _tells_sources_apart(cls, url: str | None) -> str | None:
        known = url is None or url.startswith(("http://", "https://"))
        if not known or (url is not None and "{source_id}" not in url):
            raise ValueError("an address of http or https with {source_id} in it, or null")
        return url


class SixDRepNet(Section):
    """6DRepNet angles: frame, pitch, yaw, roll in degrees, in a table of all clips with a clip_id,
    or in <clip_id>.csv in a folder."""

    file: str = Field("head_pose.csv", description="the table or the folder, under data_dir")


class OpenFacePose(Section):
    """OpenFace's tables: <clip_id>.csv or <source_id>.csv in a folder, or one table of all clips
    with a clip_id."""

    file: str = Field("openface", description="the table or the folder, under data_dir")


class Pose(Section):
    format: Literal["sixdrepnet", "openface", "motion"] = Field(
        "sixdrepnet", description="head angles from tables, or from the tracker's own motion"
    )
    sixdrepnet: SixDRepNet = SixDRepNet()
    openface: OpenFacePose = OpenFacePose()
    max_yaw_deg: Positive = Field(35.0, description="largest |yaw|, degrees (Höll 2024, 5.1)")


class Describe(Section):
    """Sentences about what the clips show (Höll 2024, 5.3 and chapter 8)."""

    texts: Count = Field(3, description="descriptions per clip and source of what it shows")
    min_s: Positive = Field(
        1.0, description="what lasts less is told in passing, and splits no time, seconds"
    )
    max_stretches: Count = Field(
        5, description="stretches of a description; of more, the shortest are told in passing"
    )
    max_words: Count = Field(
        50,
        description="words of a description, about: 50 fit CLIP's 77 tokens; the rest is left out",
    )
    templates: str | None = Field(
        None, description="YAML with wording of your own; null: resources/descriptions.yaml alone"
    )
    balance: Share = Field(
        0.5,
        description="how far clips that show something rare are weighted up: 0 not at all, 1 until "
        "everything counts about the same",
    )
    seed: Seed = Field(0, description="seed of the choice of words")
