"""A pickle machine that runs nothing.

It knows the opcodes that data needs and no others. What a pickle names is looked up in an
allow-list of stand-ins; no module is imported, nothing is called that the caller did not give.
Time and memory are bounded by the length of the pickle: opcodes are counted, every length is
checked against the bytes that are there, the memo is a dictionary, there is no recursion, and keys
are text or numbers, since even hashing a nested tuple would recurse. What the memo can bring back
again and again is not worked on at length: arguments are few, keys short.
"""

import codecs
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from struct import Struct
from struct import error as TooShort
from typing import Any

MAX_OPCODES = 100_000
MOST_ARGUMENTS, LONGEST_KEY = 16, 1_000
LONGEST_NAME = 80  # of a name in a message
GARBLED = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, TooShort, Warning)


class Refused(Exception):
    """A pickle holds what data does not need, or breaks off."""


@dataclass(frozen=True)
class Known:
    """A name that a pickle may mention, and what stands for calling it. make raises Refused."""

    make: Callable[..., Any]


class Standin:
    """What stands for an object of a known name."""

    def fill(self, state) -> None:
        """Take over the state that the pickle gives to the object."""
        raise Refused("a state for what has none")


def unpickle(
    raw: bytes,
    names: Mapping[str, Any],
    storage: Callable[[Any], Any] | None = None,
    start: int = 0,
    most: int = MAX_OPCODES,
) -> tuple[Any, int]:
    """The content of the pickle that begins at a place of raw, and the place after it.

    names: "module.name" → Known or a plain value. storage: what a persistent id means; None: none
    may occur. most: opcodes that it may have. Text of Python 2 stays bytes. Raises Refused.
    """
    try:
        return _run(raw, _Machine(raw, names, storage), start, most)
    except GARBLED as error:
        raise Refused("a pickle that breaks off or is garbled") from error


def _run(raw, machine, at, most):
    stack, memo = machine.stack, machine.memo
    for _ in range(most):
        code = raw[at]
        at += 1
        if code == BINPUT:  # these four are most of any pickle
            memo[raw[at]] = stack[-1]
            at += 1
        elif code == BINGET:
            stack.append(memo[raw[at]])
            at += 1
        elif code == BININT1:
            stack.append(raw[at])
            at += 1
        elif code == MEMOIZE:
            memo[len(memo)] = stack[-1]
        elif code == STOP:
            return stack.pop(), at
        elif code in STEPS:
            machine.at = at
            STEPS[code](machine)
            at = machine.at
        else:
            raise Refused(f"opcode {chr(code)!r} in a pickle")
    raise Refused(f"a pickle of more than {most} opcodes")


class _Machine:
    def __init__(self, raw, names, storage):
        self.raw, self.names, self.storage, self.at = raw, names, storage, 0
        self.stack, self.marks, self.memo = [], [], {}
        self.made = 0  # bytes that calls have made

    def take(self, size: int) -> bytes:
        start, self.at = self.at, self.at + size
        if size < 0 or self.at > len(self.raw):
            raise Refused("a pickle that breaks off")
        return self.raw[start : self.at]

    def take_counted(self, length: Struct) -> bytes:
        start = self.at + length.size
        self.at = end = start + length.unpack_from(self.raw, self.at)[0]
        if not start <= end <= len(self.raw):
            raise Refused("a pickle that breaks off")
        return self.raw[start:end]

    def number(self, kind: Struct) -> int | float:
        (value,) = kind.unpack_from(self.raw, self.at)
        self.at += kind.size
        return value

    def line(self) -> bytes:
        start, end = self.at, self.raw.index(b"\n", self.at)
        self.at = end + 1
        return self.raw[start:end]

    def since_mark(self) -> list:
        start = self.marks.pop()
        items = self.stack[start:]
        del self.stack[start:]
        return items

    def name(self, module: str, name: str):
        try:
            return self.names[f"{module}.{name}"]
        except KeyError:
            found = repr(f"{module}.{name}"[:LONGEST_NAME])[1:-1]  # no control characters
            raise Refused(f"the name {found} in a pickle") from None


BYTE, SHORT, INT, UINT = Struct("<B"), Struct("<H"), Struct("<i"), Struct("<I")
LONG, DOUBLE = Struct("<Q"), Struct(">d")


def _is(value) -> Callable[[_Machine], None]:
    return lambda m: m.stack.append(value)


def _makes(kind: type) -> Callable[[_Machine], None]:
    return lambda m: m.stack.append(kind())


def _number(kind: Struct) -> Callable[[_Machine], None]:
    return lambda m: m.stack.append(m.number(kind))


def _bytes(length: Struct) -> Callable[[_Machine], None]:
    return lambda m: m.stack.append(m.take_counted(length))


def _text(length: Struct) -> Callable[[_Machine], None]:
    return lambda m: m.stack.append(str(m.take_counted(length), "utf-8", "surrogatepass"))


def _put(index: Struct) -> Callable[[_Machine], None]:
    def put(m):
        m.memo[m.number(index)] = m.stack[-1]

    return put


def _get(index: Struct) -> Callable[[_Machine], None]:
    return lambda m: m.stack.append(m.memo[m.number(index)])


def _tuple1(m):
    m.stack[-1] = (m.stack[-1],)


def _tuple2(m):
    last = m.stack.pop()
    m.stack[-1] = (m.stack[-1], last)


def _tuple3(m):
    last, middle = m.stack.pop(), m.stack.pop()
    m.stack[-1] = (m.stack[-1], middle, last)


def _put_line(m):
    m.memo[int(m.line())] = m.stack[-1]


def _get_line(m):
    m.stack.append(m.memo[int(m.line())])


def _mark(m):
    m.marks.append(len(m.stack))


def _tuple(m):
    m.stack.append(tuple(m.since_mark()))


def _list(m):
    m.stack.append(m.since_mark())


def _dict(m):
    items = m.since_mark()
    m.stack.append({})
    _set(m.stack[-1], items)


def _append(m):
    value = m.stack.pop()
    _of(list, m.stack[-1]).append(value)


def _appends(m):
    values = m.since_mark()
    _of(list, m.stack[-1]).extend(values)


def _setitem(m):
    value, key = m.stack.pop(), m.stack.pop()
    _set(m.stack[-1], (key, value))


def _setitems(m):
    items = m.since_mark()
    _set(m.stack[-1], items)


def _set(target, items):
    content = _of(dict, target)
    for key, value in zip(items[::2], items[1::2], strict=True):
        if type(key) is not int and (type(key) not in (str, bytes) or len(key) > LONGEST_KEY):
            raise Refused("a dictionary with keys that are no names")
        content[key.decode("latin1") if type(key) is bytes else key] = value


def _of(kind: type, value):
    if not isinstance(value, kind):
        raise Refused("a pickle that is garbled")
    return value


def _few(arguments) -> tuple:
    if type(arguments) is not tuple or len(arguments) > MOST_ARGUMENTS:
        raise Refused("a pickle that is garbled")
    return arguments


def _global(m):
    module, name = m.line(), m.line()
    m.stack.append(m.name(module.decode(), name.decode()))


def _stack_global(m):
    name, module = _of(str, m.stack.pop()), _of(str, m.stack.pop())
    m.stack.append(m.name(module, name))


def _call(m):
    arguments, known = _few(m.stack.pop()), m.stack.pop()
    if not isinstance(known, Known):
        raise Refused("a pickle that calls what is no name")
    made = known.make(*arguments)
    if type(made) is bytes:
        m.made += len(made)
        if m.made > len(m.raw):
            raise Refused("a pickle that makes more bytes than it has")
    m.stack.append(made)


def _build(m):
    state, target = m.stack.pop(), m.stack[-1]
    if not isinstance(target, Standin):
        raise Refused("a state for what has none")
    target.fill(state)


def _stored(m):
    if m.storage is None:
        raise Refused("a persistent id in a pickle")
    m.stack.append(m.storage(_few(m.stack.pop())))


def _persistent_line(m):
    raise Refused("a persistent id in a pickle")


def _long(m):
    m.stack.append(int.from_bytes(m.take_counted(BYTE), "little", signed=True))


def _int_line(m):
    line = m.line()
    booleans = {b"00": False, b"01": True}
    m.stack.append(booleans[line] if line in booleans else int(line))


def _long_line(m):
    m.stack.append(int(m.line().removesuffix(b"L")))


def _float_line(m):
    m.stack.append(float(m.line()))


def _string_line(m):
    quoted = m.line()
    if len(quoted) < 2 or quoted[0] != quoted[-1] or quoted[:1] not in (b"'", b'"'):
        raise Refused("a pickle that is garbled")
    m.stack.append(codecs.escape_decode(quoted[1:-1])[0])


def _unicode_line(m):
    m.stack.append(str(m.line(), "raw-unicode-escape"))


def _skip(size: int) -> Callable[[_Machine], None]:
    return lambda m: m.take(size)


BINPUT, BINGET, BININT1, MEMOIZE, STOP = b"qhK\x94."
STEPS: dict[int, Callable[[_Machine], None]] = {
    code[0]: step
    for code, step in {
        b"\x80": _skip(1),  # PROTO
        b"\x95": _skip(8),  # FRAME
        b"r": _put(UINT),
        b"p": _put_line,
        b"j": _get(UINT),
        b"g": _get_line,
        b"M": _number(SHORT),
        b"J": _number(INT),
        b"G": _number(DOUBLE),
        b"\x8a": _long,  # LONG1; nothing needs LONG4
        b"I": _int_line,
        b"L": _long_line,
        b"F": _float_line,
        b"N": _is(None),
        b"\x88": _is(True),
        b"\x89": _is(False),
        b"X": _text(UINT),
        b"\x8c": _text(BYTE),
        b"\x8d": _text(LONG),
        b"V": _unicode_line,
        b"B": _bytes(UINT),
        b"C": _bytes(BYTE),
        b"\x8e": _bytes(LONG),
        b"\x96": _bytes(LONG),  # BYTEARRAY8
        b"T": _bytes(INT),
        b"U": _bytes(BYTE),
        b"S": _string_line,
        b"(": _mark,
        b")": _is(()),
        b"t": _tuple,
        b"\x85": _tuple1,
        b"\x86": _tuple2,
        b"\x87": _tuple3,
        b"]": _makes(list),
        b"l": _list,
        b"a": _append,
        b"e": _appends,
        b"}": _makes(dict),
        b"d": _dict,
        b"s": _setitem,
        b"u": _setitems,
        b"c": _global,
        b"\x93": _stack_global,
        b"R": _call,
        b"\x81": _call,  # NEWOBJ: the class and the arguments of its __new__
        b"b": _build,
        b"Q": _stored,
        b"P": _persistent_line,
    }.items()
}
