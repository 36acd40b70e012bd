"""Sentences as HumanML3D's text files have them: `caption#word/TAG word/TAG#start#end`.

Its loaders look a word's vector up by `word/TAG`, split at `#`, blank and `/`. Words of closed
classes have their tag here; nobody tags the others, and `OTHER` is what the loaders call that.
"""

import re

_CLASSES: dict[str, str] = {
    "DET": "a an the this that these those each every some any no another both",
    "PRON": "he she it they him her them his hers its their theirs who himself herself themselves",
    "AUX": "is are was were be been being am has have had do does did can could will would may",
    "ADP": "in on at to from of for with by into onto over under up down between during before "
    "after until without against toward towards",
    "NUM": "one two three four five six seven eight nine ten",
    "ADV": "then not again once twice finally first next last later quickly slowly briefly",
}
_TAGS = {word: tag for tag, of in _CLASSES.items() for word in of.split()}
_WORD = re.compile(r"[^\W_]+(?:['’][^\W_]+)*")  # letters and digits: neither # nor / nor blank
WHOLE = "0.0#0.0"  # of what start and end a loader makes the clip as a whole


def line(text: str) -> str:
    """A sentence about a whole clip as a line, without its end; empty where it has no word."""
    caption = " ".join(text.replace("#", " ").split())
    words = _WORD.findall(caption.casefold())
    tokens = " ".join(f"{w}/{'NUM' if w.isdigit() else _TAGS.get(w, 'OTHER')}" for w in words)
    return f"{caption}#{tokens}#{WHOLE}" if tokens else ""
