"""What a file that is no video gives itself away as, from how it begins."""

SIGNATURES = (
    (b"\x89PNG", "a picture (PNG)"),
    (b"\xff\xd8\xff", "a picture (JPEG)"),
    (b"GIF8", "a picture (GIF)"),
    (b"BM", "a picture (BMP)"),
    (b"version https://git-lfs", "a Git LFS pointer, not the file itself"),
    (b"#EXTM3U", "a playlist (HLS)"),
    (b"ffconcat", "a playlist (ffconcat)"),
    (b"ID3", "sound without pictures (MP3)"),
    (b"OggS", "an Ogg file"),
    (b"fLaC", "sound without pictures (FLAC)"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"%PDF", "a PDF document"),
)


def kind_of(head: bytes) -> str | None:
    """What a file is that begins with head, where that is surely no video; else None."""
    if not head:
        return "an empty file"
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "a picture (WebP)"
    if head[:4] == b"RIFF" and head[8:12] == b"WAVE":
        return "sound without pictures (WAV)"
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip().lower()
    if text.startswith((b"<!doctype html", b"<html", b"<head", b"<script")):
        return "an HTML page"
    if text.startswith(b"<?xml"):
        return "an XML file"
    for signature, kind in SIGNATURES:
        if head.startswith(signature):
            return kind
    return None
