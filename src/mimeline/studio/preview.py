"""The page that shows a motion, or what a timeline asks for, on a face that can be turned.

The face goes to the browser as the glTF that people export: what is seen is what others will open.
"""

import tempfile
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from flask import Blueprint, Flask, Response, abort, render_template

from mimeline.exchange.reading import Reading
from mimeline.face import gltf
from mimeline.face.load import load_driven_face
from mimeline.face.model import Face
from mimeline.face.render import DISTANCE, extent
from mimeline.inspection.options import Options
from mimeline.motion.formats import scene
from mimeline.studio import server
from mimeline.studio.preview_facts import told
from mimeline.studio.previewed import Clip, Previewed, previewed
from mimeline.studio.review import TELL

KEPT = 6  # moving faces: of a file of many clips, those that were looked at last
EMBEDDED = "the embedded face"
GLB = "model/gltf-binary"


class Stage:
    """The clips on a face, numbered over all files, each written as glTF when it is asked for."""

    def __init__(self, shown: Sequence[Previewed], face: Face, face_name: str, folder: Path):
        self.shown, self.face, self.face_name = shown, face, face_name
        self.clips: list[Clip] = [clip for own in shown for clip in own.clips]
        self._folder, self._written = folder, []
        self._one = threading.Lock()

    def told(self) -> dict[str, Any]:
        """The files with their clips, and the face."""
        files, number = [], 0
        for own in self.shown:
            clips = [{"number": number + n, "name": clip.name} for n, clip in enumerate(own.clips)]
            files.append({"name": own.path.resolve().name, "path": str(own.path), "clips": clips})
            files[-1]["first"] = number + own.first
            number += len(clips)
        middle, half = extent(self.face)
        face = {"name": self.face_name, "middle": middle, "half": half, "distance": DISTANCE}
        return {"files": files, "face": face | {"unsaid": list(gltf.unsaid(self.face))}}

    def glb(self, number: int) -> bytes:
        """A clip on the face. Raises BadFile for one without a valid frame."""
        path = self._folder / f"{number}.glb"
        with self._one:
            if number not in self._written:
                scene.write(self.clips[number].motion, path, self.face)
                self._written.append(number)
            self._written.sort(key=number.__eq__)  # stable: the last one was asked for last
            while len(self._written) > KEPT:
                (self._folder / f"{self._written.pop(0)}.glb").unlink()
            return path.read_bytes()


def serve(
    paths: Sequence[Path],
    face: Path | None,
    options: Options,
    reading: Reading,
    port: int,
    open_browser: bool,
    say: Callable[[str], None] = TELL,
) -> None:
    """Serve the page until Ctrl-C.

    paths: one file, or two to be seen side by side. face: None for the embedded one. options,
    reading: how they are read, see `previewed`. port: 0 for any.
    Raises what `previewed` and `load_driven_face` do; PortTaken.
    """
    actor, shown = load_driven_face(face), previewed(paths, options, reading)
    with tempfile.TemporaryDirectory(prefix="mimeline-preview-") as folder:
        stage = Stage(shown, actor, Path(face).name if face else EMBEDDED, Path(folder))
        server.serve(lambda key: preview(stage, key), port, open_browser, say)


def preview(stage: Stage, key: str) -> Flask:
    """The page's app. key: see server.studio."""
    page = Blueprint("preview", __name__)

    def asked(number: int) -> Clip:
        if number >= len(stage.clips):
            abort(404, "There is no such clip.")
        return stage.clips[number]

    @page.get("/")
    def index() -> str:
        names = [own.path.resolve().name for own in stage.shown]
        named = {"names": " and ".join(names), "face": stage.face_name}
        return render_template("preview.html", two=len(names) > 1, **named)

    @page.get("/files")
    def files() -> dict:
        return stage.told()

    @page.get("/motions/<int:number>")
    def motion(number: int) -> dict:
        return told(asked(number))

    @page.get("/face/<int:number>.glb")
    def face(number: int) -> Response:
        asked(number)
        return Response(stage.glb(number), mimetype=GLB)

    return server.studio(page, {}, Path(), key)
