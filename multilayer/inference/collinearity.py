"""Collinear parameters: which of them the data determine only in combination, in what combination, and how well.

By the eigenvalues of the correlation matrix, as collinearity of a regression: D. A. Belsley, E. Kuh & R. E. Welsch,
Regression Diagnostics, Wiley 1980, ch. 3; of identifiability: R. Brun, P. Reichert & H. R. Künsch, Water Resour. Res.
37 (2001) 1015-1030.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from multilayer.inference.priors import Parameter

OPEN = 1.0  # an eigenvalue of J^T J below it: the prior says more of this direction than the data
_CORRELATED = 0.95
_LINKED = 0.15  # least entry of two parameters in the projector on the open directions that links them
_MEMBER = 0.15  # least weight of a member, in a combination of unit length
_BETTER = 2.0  # a combination is reported when it is known so many times better than its members
PREFIX = "ln "  # of the names of parameters whose value is a logarithm


@dataclass(frozen=True)
class Group:
    """Parameters of which the data determine a combination better than each by itself.

    Attributes
    ----------
    names : tuple of str
    correlation : float
        Between two of them; the largest in absolute value.
    exponents : tuple of float
        Powers of logarithmic parameters in the combination, factors of others; the first is 1.
    combination : str
        The combination in symbols.
    std : float
        Standard deviation of the combination; relative where it is a product.
    times_better : float
        How much better it is known than if the members' uncertainties were independent.
    text : str
        A sentence that says so.
    """

    names: tuple[str, ...]
    correlation: float
    exponents: tuple[float, ...]
    combination: str
    std: float
    times_better: float
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)


def collinear_groups(
    parameters: Sequence[Parameter], z: RealArray, information: RealArray, covariance: RealArray
) -> list[Group]:
    """Return the combinations that are known better than their members, the most informative first.

    Parameters
    ----------
    parameters : sequence of Parameter, n of them
    z : array, shape (n,)
        Coordinates of a minimum.
    information : array, shape (n, n)
        ``J^T J`` there.
    covariance : array, shape (n, n)
        Posterior covariance of the coordinates.
    """
    groups = []
    for members in _linked(information, covariance):
        stds = np.sqrt(np.diag(covariance)[members])
        correlation = covariance[np.ix_(members, members)] / np.outer(stds, stds)
        values, vectors = np.linalg.eigh(correlation)
        linked = [parameters[k] for k in members]
        for value, vector in zip(values, vectors.T, strict=True):
            kept = np.flatnonzero(np.abs(vector) > _MEMBER)
            if value < _BETTER**-2 and len(kept) > 1:
                slopes = [parameter.prior.slope(float(at)) for parameter, at in zip(linked, z[members], strict=True)]
                factors = vector / (stds * np.array(slopes))
                groups.append(
                    _group([linked[k] for k in kept], factors[kept], float(value), correlation[np.ix_(kept, kept)])
                )
    return sorted(groups, key=lambda group: -group.times_better)


def _linked(information: RealArray, covariance: RealArray) -> list[list[int]]:
    """Return groups of parameters with correlations near 1, or open directions in common."""
    values, vectors = np.linalg.eigh(information)
    undetermined = vectors[:, values < OPEN]
    # the projector, not its vectors, which rotate freely among equal eigenvalues
    projector = undetermined @ undetermined.T
    stds = np.sqrt(np.diag(covariance))
    correlated = np.abs(covariance / np.outer(stds, stds)) > _CORRELATED
    return _components((np.abs(projector) > _LINKED) | correlated)


def _components(edges: BoolArray) -> list[list[int]]:
    """Return the connected components of a graph that have more than one node."""
    components: list[list[int]] = []
    unvisited = set(range(len(edges)))
    while unvisited:
        component: set[int] = set()
        new = {unvisited.pop()}
        while new:
            component |= new
            new = {j for i in new for j in np.flatnonzero(edges[i]).tolist()} - component
        unvisited -= component
        if len(component) > 1:
            components.append(sorted(component))
    return components


def _group(chosen: Sequence[Parameter], factors: RealArray, eigenvalue: float, correlation: RealArray) -> Group:
    std, better = np.sqrt(max(eigenvalue, 0.0)) / abs(factors[0]), 1 / np.sqrt(max(eigenvalue, 1e-30))
    powers = factors / factors[0]
    names = tuple(shown_name(parameter) for parameter in chosen)
    product = all(_is_logarithmic(parameter) for parameter in chosen)
    combination = _product(names, powers) if product else _sum(chosen, powers)
    alike = (("ratio", "product") if product else ("difference", "sum"))[bool(powers[1] > 0)]
    kind = f"a {alike}-like combination" if len(names) == 2 else "a combination"
    within = f"{100 * std:.2g} %" if product else f"{std:.2g}"
    text = (
        f"{', '.join(names[:-1])} and {names[-1]} are known best as {kind}: {combination} to within {within}, "
        f"{better:.2g} times better than they would give by themselves"
    )
    off_diagonal = correlation - np.eye(len(chosen))
    largest = float(off_diagonal.flat[int(np.abs(off_diagonal).argmax())])
    exponents = tuple(float(p) for p in powers)
    return Group(tuple(p.name for p in chosen), largest, exponents, combination, float(std), float(better), text)


def shown_name(parameter: Parameter) -> str:
    """Return a parameter's name without the prefix of logarithms."""
    return parameter.name.removeprefix(PREFIX)


def _is_logarithmic(parameter: Parameter) -> bool:
    return parameter.prior.is_logarithmic or parameter.name.startswith(PREFIX)


def _product(names: Sequence[str], powers: RealArray) -> str:
    above = [_power(name, p) for name, p in zip(names, powers, strict=True) if p > 0]
    below = [_power(name, -p) for name, p in zip(names, powers, strict=True) if p < 0]
    return " / ".join([" · ".join(above), *below])


def _power(name: str, power: float) -> str:
    name = f"({name})" if "/" in name or "*" in name else name
    return name if abs(power - 1) < 0.05 else f"{name}^{power:.2g}"


def _sum(chosen: Sequence[Parameter], factors: RealArray) -> str:
    terms = []
    for parameter, factor in zip(chosen, factors, strict=True):
        name = f"ln {shown_name(parameter)}" if _is_logarithmic(parameter) else parameter.name
        size = "" if abs(abs(factor) - 1) < 0.005 else f"{abs(factor):.2g} "
        terms.append(f"{'-' if factor < 0 else '+'} {size}{name}")
    return " ".join(terms).removeprefix("+ ")
