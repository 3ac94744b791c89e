"""Inverse methods: what each says of itself, and their registry.

A method is a class in one file, registered by an entry point in the group ``multilayer.methods``, the built-in ones
too. ``multilayer fit --method NAME`` runs it, and ``multilayer methods`` puts its moduli beside those of the others.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, Self, TypeVar

from multilayer.fits.result import FitResult
from multilayer.registry import Registry, subclass_fault

if TYPE_CHECKING:
    from multilayer.fits.sources import FitJob

LEAST_SQUARES, NELDER_MEAD = BURST_BY_BURST = ("least-squares", "nelder-mead")
JOINT, STACKS = "joint", "stacks"

J = TypeVar("J")
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Method(ABC, Generic[J]):
    """An inverse method, which fits jobs of the type `J`.

    Fields of a subclass that is a dataclass are options of the command line that it takes, by their names.

    Attributes
    ----------
    name : str
        Under which it is registered.
    title : str
        What it is, in a few words, for tables.
    summary : str
        In a line what it does.
    reads : {'campaign', 'stack-fit'}
        The file it needs: a campaign or a fit file of one, or a file about stacks.
    gives : type
        What `run` returns, `FitResult` or a kind of it.
    of_settings : tuple of str
        Options of the command line that change settings of the fit file: ``model``, if it minds that.
    suffix : str
        What a folder of results is called after the name of what was fitted.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    summary: ClassVar[str]
    reads: ClassVar[Literal["campaign", "stack-fit"]]
    gives: ClassVar[type[FitResult]] = FitResult
    of_settings: ClassVar[tuple[str, ...]] = ()
    suffix: ClassVar[str] = ""

    @classmethod
    def options(cls) -> tuple[str, ...]:
        """Return the names of the command line's options that it takes."""
        return (*cls.of_settings, *(field.name for field in fields(cls)))

    @staticmethod
    def written(option: str) -> str:
        """Return an option as the command line has it: ``given`` is ``--with`` there, a word of Python itself."""
        return "--with" if option == "given" else f"--{option}"

    @classmethod
    def with_options(cls, options: Mapping[str, Any]) -> Self:
        """Return it with those of the options that it takes and that are given, not None."""
        known = {field.name for field in fields(cls)}
        return cls(**{name: value for name, value in options.items() if name in known and value is not None})

    @abstractmethod
    def number_of_steps(self, job: J) -> int:
        """Return how often `run` reports progress."""

    @abstractmethod
    def run(self, job: J, tell: Progress) -> FitResult:
        """Return what the method says of a job that was read.

        Parameters
        ----------
        job : FitJob or StackJob
        tell : callable
            Called with a short text after every step.

        Raises
        ------
        InputError
            When the method cannot be used for this job.
        """


@dataclass(frozen=True)
class Compared:
    """What stands in a comparison of methods under a name.

    Attributes
    ----------
    title : str
        What it is, in a few words.
    job : FitJob or None
        What is fitted for it; None where it is left out.
    reason : str
        Why it is left out.
    """

    title: str
    job: FitJob | None
    reason: str = ""


class CampaignMethod(Method["FitJob"]):
    """A method for campaigns on the two-plate rig.

    Attributes
    ----------
    slow : bool
        Whether a comparison of methods does without it unless it is asked for.
    """

    reads: ClassVar[Literal["campaign", "stack-fit"]] = "campaign"
    slow: ClassVar[bool] = False

    def number_of_steps(self, job: FitJob) -> int:
        """Return how often `run` reports progress: once per burst, unless a method says otherwise."""
        return sum(len(configuration.bursts) for configuration in job.campaign.configurations)

    def compared(self, job: FitJob) -> Mapping[str, Compared]:
        """Return what a comparison of methods lists of it, by name; nothing where it gives bursts no moduli."""
        return {self.name: Compared(self.title, job)}


def _fault(name: str, item: Any) -> str:
    fault = subclass_fault(Method, "name")(name, item)
    unsaid = [word for word in ("title", "summary", "reads") if not getattr(item, word, "")]
    return fault or (f"it says no {', '.join(unsaid)}" if unsaid else "")


METHODS: Registry[type[Method[Any]]] = Registry("multilayer.methods", "method", _fault)
