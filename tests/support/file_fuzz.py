"""Files of every kind that is read, spoiled: what may come of it is an error of this project, and nothing else."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from dp_bringup.parameter_file import read_parameter_file
from dp_tools.open_water.load import load_trial
from dp_tools.scenario import load_scenario
from marine_model import load_vessel
from marine_model.errors import DpError
from marine_model.propeller_file import load_propeller
from marine_model.wave_response.load import load_wave_response
from support.bag_fuzz import chunks, of_chunk, read_spoiled_bag, run_bags
from support.repository import ROOT

SOURCE = ROOT / "src"
MODEL = SOURCE / "marine_model" / "marine_model"
BRINGUP = SOURCE / "dp_bringup"


@dataclass(frozen=True)
class Kind:
    """One kind of file.

    Parameters
    ----------
    read
        What reads it.
    suffix
        Of its name.
    seeds
        Good ones to begin with.
    packed
        Makes the file of what is spoiled.
    """

    read: Callable[[Path], object]
    suffix: str
    seeds: Callable[[], tuple[bytes, ...]]
    packed: Callable[[bytes], bytes] = bytes


def _files(folder: Path, pattern: str) -> Callable[[], tuple[bytes, ...]]:
    return lambda: tuple(path.read_bytes() for path in sorted(folder.glob(pattern)))


KINDS = {
    "vessel": Kind(load_vessel, ".yaml", _files(MODEL / "vessels", "*.yaml")),
    "scenario": Kind(load_scenario, ".yaml", _files(BRINGUP / "scenarios", "*.yaml")),
    "parameters": Kind(read_parameter_file, ".yaml", _files(BRINGUP / "config", "*.yaml")),
    "propeller": Kind(load_propeller, ".yaml", _files(MODEL / "propeller_files", "*.yaml")),
    "open_water": Kind(load_trial, ".yaml", _files(BRINGUP / "open_water", "*.yaml")),
    "wave_response": Kind(load_wave_response, ".csv", _files(MODEL / "wave_response", "*.csv")),
    "bag": Kind(read_spoiled_bag, ".mcap", run_bags),
    "chunk": Kind(read_spoiled_bag, ".mcap", chunks, of_chunk),
}

_TOKENS = (
    *(
        b"nan",
        b".nan",
        b"inf",
        b"-.inf",
        b"1e400",
        b"-1e308",
        b"5e-324",
        b"0",
        b"-1",
        b"1e9",
        b"99999999999999999999999",
    ),
    *(
        b"true",
        b"null",
        b"~",
        b"''",
        b"[]",
        b"{}",
        b"[[1]]",
        b"{a: 1}",
        b"&a",
        b"*a",
        b"!!python/object:os.system",
        b"2026-11-22",
    ),
    *(
        b"\xff\xfe",
        b"\0",
        b"\xe2\x80\xa8",
        b"\t",
        b"<<: *a",
        b"- - - -",
        b"? x",
        b"%YAML 9.9",
        b"---",
        b"...",
        b"0x7fffffffffffffff",
    ),
    *(b"cybership3", b"../../x", b"a.csv", b"/dev/null", b"no such"),
)
_WORD = re.compile(rb"[-+.\w]+")


def spoiled(content: bytes, seed: int) -> bytes:
    """Return a file that was a good one: lines, words and bytes changed, dropped, doubled and moved."""
    chance = random.Random(seed)
    for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
        content = chance.choice(_CHANGES)(content, chance)
    return content


def _line(content: bytes, chance: random.Random) -> bytes:
    lines = content.split(b"\n")
    i, j = chance.randrange(len(lines)), chance.randrange(len(lines))
    action = chance.randrange(4)
    if action == 0:
        del lines[i]
    elif action == 1:
        lines.insert(j, lines[i])
    elif action == 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines[i] = b"  " * chance.randrange(4) + lines[i].strip()
    return b"\n".join(lines)


def _word(content: bytes, chance: random.Random) -> bytes:
    found = [*_WORD.finditer(content)]
    if not found:
        return chance.choice(_TOKENS)
    match = chance.choice(found)
    other = chance.choice(_TOKENS) if chance.random() < 0.7 else chance.choice(found).group()
    return content[: match.start()] + other + content[match.end() :]


def _byte(content: bytes, chance: random.Random) -> bytes:
    changed = bytearray(content or b"\0")
    for _ in range(chance.choice((1, 1, 4, 64))):
        changed[chance.randrange(len(changed))] = chance.randrange(256)
    return bytes(changed)


def _cut(content: bytes, chance: random.Random) -> bytes:
    start, end = sorted((chance.randrange(len(content) + 1), chance.randrange(len(content) + 1)))
    return content[:start] if chance.random() < 0.5 else content[:start] + content[end:]


_CHANGES = (_word, _word, _word, _line, _line, _byte, _cut)


def outcome(kind: Kind, content: bytes, path: Path) -> DpError | None:
    """Read ``content`` as a file; return the error that was made of it, if it is one of this project."""
    path.write_bytes(kind.packed(content))
    try:
        kind.read(path)
    except DpError as error:
        return error
    return None
