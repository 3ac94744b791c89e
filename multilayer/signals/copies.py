"""Recordings that hold the same samples: a file copied under two names, a repeat exported twice."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import sha256

from multilayer.signals.recording import Recording

_SHOWN = 3


def samples_of(recording: Recording) -> tuple[bytes, ...]:
    """Return what stands for the samples of each repeat: two are the same only where all samples of both channels are.

    Parameters
    ----------
    recording : Recording
        As it was read, nothing taken off.
    """
    both = zip(recording.base, recording.top, strict=True)
    return tuple(sha256(base.tobytes() + top.tobytes()).digest() for base, top in both)


def copies_in_words(samples: Mapping[str, tuple[bytes, ...]]) -> list[str]:
    """Return sentences about recordings that share a repeat, and about repeats that are the same; noise never is twice.

    Parameters
    ----------
    samples : mapping
        Of each recording, by its file, what `samples_of` returned.
    """
    texts = []
    first: dict[bytes, str] = {}
    for file, repeats in samples.items():
        for repeat in repeats:
            first.setdefault(repeat, file)
    shared = {file: {first[repeat] for repeat in repeats} - {file} for file, repeats in samples.items()}
    if pairs := [f"{min(others)} and {file}" for file, others in shared.items() if others]:
        texts.append(
            f"recordings hold the same samples: {_listed(pairs)}; noise is never twice the same: one is a copy under "
            "another name; put the right recording in its place, or remove that burst"
        )
    if again := [file for file, repeats in samples.items() if len(set(repeats)) < len(repeats)]:
        texts.append(
            f"repeats hold the same samples in {len(again)} of {len(samples)} recordings ({_listed(again)}): the noise "
            "is told from how repeats differ, and is taken for too small; export each repeat once"
        )
    return texts


def _listed(names: list[str]) -> str:
    rest = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + rest
