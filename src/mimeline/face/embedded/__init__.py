"""The face that mimeline brings: made by code, free to use for anything."""

from mimeline.face.embedded.assembly import embedded_face

__all__ = ["embedded_face"]
