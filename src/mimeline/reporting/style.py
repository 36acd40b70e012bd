"""The page's colours: one per action in every picture, in a light and a dark theme."""

from collections.abc import Mapping

from mimeline.vocabulary import ACTIONS, NEUTRAL

_COLOURS: dict[str, tuple[str, str]] = {  # name → light, dark; a region has a family of hues
    "BrowUp": ("#e2a33b", "#e8b04f"),
    "BrowDown": ("#96621d", "#b57d35"),
    "EyeSquint": ("#2c66ab", "#4c8ad2"),
    "EyeWiden": ("#74b0e4", "#93c5f0"),
    "EyeClose": ("#566174", "#8290a6"),
    "SoftSmile": ("#f0949c", "#f2a0a8"),
    "Smile": ("#cb3355", "#dd5573"),
    "MouthFrown": ("#792748", "#a94a70"),
    "GazeLeft": ("#39a888", "#4cbb9b"),
    "GazeRight": ("#116b58", "#3a9c86"),
    "GazeUp": ("#9cc257", "#accf6b"),
    "GazeDown": ("#557d22", "#749c3e"),
    "HeadLeft": ("#9a83d8", "#ad98e6"),
    "HeadRight": ("#553a99", "#7d63c4"),
    "HeadUp": ("#cd95dc", "#d8a6e5"),
    "HeadDown": ("#87429b", "#b074c3"),
    NEUTRAL: ("#d3cec3", "#44474d"),
}
_PAGE: dict[str, tuple[str, str]] = {
    "paper": ("#fbfaf6", "#17191c"),
    "raised": ("#f3f0e8", "#1f2226"),
    "ink": ("#22211e", "#e4e1da"),
    "soft": ("#6a665d", "#a09c93"),
    "faint": ("#b3aea2", "#62615e"),
    "rule": ("#dfdacd", "#33363b"),
    "accent": ("#a63a24", "#e58a70"),
    "kept": ("#5d7f73", "#6f9587"),
    "dropped": ("#d9a441", "#d9a441"),
    "failed": ("#b5402b", "#d8654f"),
    "line-a": ("#22211e", "#f0ede6"),
    "line-b": ("#c2572f", "#ee9468"),
    "line-c": ("#3c7a96", "#79b7d2"),
    "real": ("#989388", "#8b8a86"),
}
_DARK_TEXT, _LIGHT_TEXT = "#1d1c1a", "#ffffff"


def themes() -> dict[str, dict[str, str]]:
    """CSS variables of the light and the dark theme: `--BrowUp`, `--on-BrowUp` (text on it), …"""
    return {theme: dict(_variables(place)) for place, theme in enumerate(("light", "dark"))}


def _variables(place: int):
    for name, colours in (_PAGE | _COLOURS).items():
        yield f"--{name}", colours[place]
    for name in _COLOURS:
        yield f"--on-{name}", readable_on(_COLOURS[name][place])


def readable_on(colour: str) -> str:
    """Dark or light text, whichever has the greater contrast on the colour (WCAG 2.1)."""
    ground = _luminance(colour)
    dark = (ground + 0.05) / (_luminance(_DARK_TEXT) + 0.05)
    light = (_luminance(_LIGHT_TEXT) + 0.05) / (ground + 0.05)
    return _DARK_TEXT if dark >= light else _LIGHT_TEXT


def _luminance(colour: str) -> float:
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(weight * c for weight, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def colours() -> Mapping[str, tuple[str, str]]:
    """The light and the dark colour of each action and of Neutral."""
    return dict(_COLOURS)


assert set(_COLOURS) == {*ACTIONS, NEUTRAL}
