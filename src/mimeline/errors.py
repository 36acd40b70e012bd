"""The one error that users see: file, place, what was found, what was expected, what to do."""


class MimelineError(Exception):
    """A problem that the user can act on.

    file: the file or folder at fault, as the user named it.
    place: where in it ("line 812, column BrowInnerUp"), empty where the whole file is meant.
    found, expected: what stands there and what should; remedy: what to do about it.
    """

    def __init__(self, file, *, found: str, expected: str, remedy: str, place: str = ""):
        self.file, self.place = str(file), place
        self.found, self.expected, self.remedy = found, expected, remedy
        super().__init__(str(self))

    def __str__(self) -> str:
        where = f"{self.file}, {self.place}" if self.place else self.file
        text = f"{where}: found {self.found}, expected {self.expected}. {self.remedy}"
        return printable(" ".join(text.split()))  # one line, whatever a file holds


class BadFile(MimelineError):
    """A file cannot be read as what it should be."""


class NoSuchFile(BadFile):
    """A file is not there."""


class MissingColumn(MimelineError):
    """A table lacks a column that is needed."""


class BadConfig(MimelineError):
    """A key or value of the configuration is not allowed."""


class BadLabels(MimelineError):
    """A label file does not fit the clusters or the vocabulary."""


class NotPermitted(MimelineError):
    """A licence forbids what was asked for, or nobody has said that it permits it."""


def unreadable(file, error: Exception, *, expected: str, remedy: str) -> BadFile:
    """The error for a file that could not be opened or parsed, from what Python says of it."""
    if isinstance(error, FileNotFoundError):
        return NoSuchFile(file, found="no such file", expected=expected, remedy=remedy)
    return BadFile(file, found=str(error), expected=expected, remedy=remedy)


def printable(text: str) -> str:
    """The text without what could steer a terminal."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
