"""The child that downloads a file from a web server, from where it stopped; says a line of JSON."""

import json
import sys
from pathlib import Path

from mimeline.media.plain_words import broke_off
from mimeline.media.private_hosts import stay_out
from mimeline.media.ranges import OF_THE_DISK, Answered, Passing, given, replying

BLOCK = 1 << 16  # bytes


class TooLarge(Exception):
    pass


def main() -> None:
    task = json.loads(sys.argv[1])
    stay_out(task["address"])
    try:
        facts = {"as_given": transfer(**task)}
    except (Answered, Passing) as error:
        facts = error.facts
    except TooLarge as error:
        facts = {"fault": "large", "said": str(error)}
    except OSError as error:
        if error.errno not in OF_THE_DISK:
            raise
        facts = {"fault": OF_THE_DISK[error.errno], "said": str(error)}
    print(json.dumps(facts))


def transfer(
    address: str, headers: dict[str, str], target: str, max_bytes: int, stall_s: float
) -> bool:
    """Download to target; what has come of it lies in target.part until it is whole.

    stall_s: how long the server may be silent, seconds.
    Returns whether it surely is the file that lies there: come at once, as long as announced.
    Raises Answered, Passing, TooLarge; OSError of the disk.
    """
    part = Path(f"{target}.part")
    there = part.stat().st_size if part.exists() else 0
    wanted = {"Range": f"bytes={there}-"} if there else {}
    try:
        with replying(address, headers | wanted, stall_s) as reply:
            first, size = given(reply)
            there = there if there and first == there else 0
            as_given = not there and (size is not None or reply.chunked)
            if reply.status == 206 and not there:
                raise Answered(416, "another part than was asked for", None)
            with part.open("ab" if there else "wb") as file:
                while block := reply.read1(BLOCK):
                    there += len(block)
                    if max(there, size or 0) > max_bytes:
                        raise TooLarge(f"more than {max_bytes} bytes")
                    file.write(block)
    except Answered as error:
        if error.status != 416 or not wanted:
            raise
        part.unlink()  # of another file
        raise Passing(f"a download that cannot be taken up ({error})") from error
    if size is not None and there < size:
        raise Passing(broke_off(there, size))
    part.replace(target)
    return as_given


if __name__ == "__main__":
    main()
