"""The label page in a tab, and the file that it writes."""

import time
from pathlib import Path

from playwright.sync_api import Locator, Page, expect

from mimeline import tables
from mimeline.annotation.label_file import Answer, read_label_file

from .tabs import MOST_MS, POLL_MS


class LabelPage:
    """file: where the answers of the person who sits at it go."""

    def __init__(self, page: Page, file: Path):
        self.page, self.file = page, file
        expect(self.row().first).to_be_visible()

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def row(self, cluster: str | None = None) -> Locator:
        """Of a cluster, such as brow/3, in the list; of all."""
        return self.page.locator(f'[data-cluster="{cluster}"]' if cluster else "[data-cluster]")

    @property
    def shown(self) -> str:
        """The cluster that is open."""
        return self.page.locator('[data-cluster][aria-current="true"]').get_attribute(
            "data-cluster"
        )

    def open(self, cluster: str) -> None:
        """Go to a cluster."""
        self.row(cluster).click()
        self.shows(cluster)

    def shows(self, cluster: str) -> None:
        expect(self.row(cluster)).to_have_attribute("aria-current", "true")

    @property
    def cards(self) -> Locator:
        return self.page.locator("#cards figure")

    def says(self, text: str) -> None:
        expect(self.page.locator("#toast")).to_contain_text(text)

    def writes(self, cluster: str, answer: Answer | None, file: Path | None = None) -> None:
        """Wait until the file has the answer on a cluster; None: none."""
        end = time.monotonic() + MOST_MS / 1000
        while (found := self.written(file).get(cluster)) != answer:
            assert time.monotonic() < end, f"{cluster} is {found}, not {answer}"
            self.page.wait_for_timeout(POLL_MS)

    def written(self, file: Path | None = None) -> dict[str, Answer]:
        """Cluster → answer, as the file has them now."""
        file = file or self.file
        regions = read_label_file(file) if file.exists() else {}
        return {
            f"{region}/{number}": answer
            for region, own in regions.items()
            for number, answer in own.clusters.items()
        }


def first_exemplar(results: Path, cluster: str) -> str:
    """What the first card of a cluster tells of where it is from."""
    region, number = cluster.split("/")
    table = tables.read(tables.EXEMPLARS, results / "label" / "exemplars.parquet")
    own = table[(table["region"] == region) & (table["cluster"] == int(number))]
    row = own.sort_values("rank").iloc[0]
    return f"{row['clip_id']}, frames {row['start_frame']}–{row['end_frame'] - 1}"
