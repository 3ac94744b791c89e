"""What a fit of one modulus law to a whole campaign says, and how it is written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.fits.burst.acceptance import Criteria
from multilayer.fits.joint.laws import Candidate, LawMixture
from multilayer.fits.joint.posterior import modulus_intervals
from multilayer.fits.methods import JOINT
from multilayer.fits.result import BurstFit, FitResult
from multilayer.inference.derivative import central
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum
from multilayer.inference.pulls import SIGNIFICANT, largest_pulls, pulls_p_value, spreads_by_chance
from multilayer.media.laws import ModulusLaw
from multilayer.units import DB_PER_NEPER

_DECIDED = 0.9  # of the probability
_WORTH_TELLING = 0.01


@dataclass(frozen=True, repr=False, kw_only=True)
class JointFit(FitResult):
    """One law for all bursts of a campaign; `bursts` has its moduli by frequency, configuration ``joint``.

    Their differences of time of flight and level are the largest among the configurations, each a mean over its burst.

    Attributes
    ----------
    law : ModulusLaw
        The most probable one.
    problem : CampaignProblem
    minima : list of Minimum
        The distinct solutions, the most probable first.
    criteria : Criteria
        Of eq. (10), for `all_accepted`.
    candidates : tuple of Candidate
        The laws compared, with deviations of all sizes; moduli are means over them. The law by itself when empty.
    """

    kind: ClassVar[str] = JOINT
    record_name: ClassVar[str] = "joint.json"
    heading: ClassVar[tuple[str, ...]] = ("campaign",)

    law: ModulusLaw
    problem: CampaignProblem = field(repr=False)
    minima: Sequence[Minimum] = field(repr=False)
    criteria: Criteria
    candidates: tuple[Candidate, ...] = field(default=(), repr=False)

    @cached_property
    def laws(self) -> LawMixture:
        """The laws compared, by their evidence."""
        return LawMixture(self.candidates or (Candidate(self.law.law, self.problem, self.minima),))

    @property
    def facts(self) -> dict[str, Any]:
        """Single values that hold for all of it."""
        return {"campaign": self.name, "law": self.law.law, "p_value": self.p_value}

    @property
    def best(self) -> Minimum:
        """The most probable solution."""
        return self.minima[0]

    @property
    def n_data(self) -> int:
        """Number of real data."""
        return len(self.best.residual)

    @property
    def p_value(self) -> float:
        """Probability of a misfit as large as this if law, rig and stated uncertainties are right."""
        return exceeding(self.best.cost, self.n_data)

    def moduli(self, frequency: RealArray) -> tuple[ComplexArray, RealArray]:
        """Return E1 + i E2 at frequencies (n,), Hz, and the covariance of (E1, E2), shape (n, 2, 2), Pa.

        Mean and covariance over the laws compared and over deviations from them, by their evidence.
        """
        return self.laws.moments(np.asarray(frequency, dtype=float))

    @property
    def parameters(self) -> dict[str, tuple[float, float]]:
        """Value and standard deviation of the law's parameters (SI), of nuisances and of given effects, by name."""
        space, n = self.problem.space, len(self.problem.law_parameters)
        z, covariance = self.best.z, self.best.covariance
        logs, slopes = central(lambda points: space.logs(self.problem.law_coordinates(points)), z)
        spread = np.sqrt(np.einsum("ki,ij,kj->k", slopes, covariance, slopes))
        values = {name: (float(v), float(v * s)) for name, v, s in zip(space.names, np.exp(logs), spread, strict=True)}
        for i, parameter in enumerate(self.problem.nuisances.parameters, start=n):
            size = parameter.prior.normal[1] if parameter.prior.normal else 1.0
            values[parameter.name] = (size * float(z[i]), size * float(np.sqrt(covariance[i, i])))
        first = len(z) - len(self.problem.given_parameters)
        for i, parameter in enumerate(self.problem.given_parameters, start=first):
            value, slope = float(parameter.prior.value(z[i])), abs(float(parameter.prior.slope(float(z[i]))))
            size = slope * value if parameter.prior.is_logarithmic else slope  # the slope of a logarithm is relative
            values[parameter.name] = (value, size * float(np.sqrt(covariance[i, i])))
        return values

    def discrepancies(self) -> dict[str, tuple[RealArray, RealArray, RealArray]]:
        """Return frequency (Hz), time of flight (s) and level (dB), measured minus modelled, by configuration."""
        logs = self.problem.differences(self.best.z)
        return {
            data.name: (
                data.frequency,
                difference.imag / (2 * np.pi * data.frequency),
                -DB_PER_NEPER * difference.real,
            )
            for data, difference in zip(self.problem.data, logs, strict=True)
        }

    def at_bursts(self) -> list[BurstFit]:
        """Return the moduli at every frequency of the campaign, as `bursts` has them."""
        at = sorted({float(f) for data in self.problem.data for f in data.centres})
        moduli, covariance = self.moduli(np.array(at))
        delays, levels = self._worst()
        bursts = []
        for f, e, c in zip(at, moduli, covariance, strict=True):
            slope = np.array([-e.imag / e.real**2, 1 / e.real])
            std = c[0, 0] ** 0.5, c[1, 1] ** 0.5, (slope @ c @ slope) ** 0.5
            reason = self.criteria.reason(delays[f], levels[f])
            bursts.append(
                BurstFit(
                    JOINT, f, float(e.real), float(std[0]), float(e.imag), float(std[1]), float(e.imag / e.real),
                    float(std[2]), float(delays[f]), float(levels[f]), not reason, reason,
                )
            )  # fmt: skip
        return bursts

    def _worst(self) -> tuple[dict[float, float], dict[float, float]]:
        delays: dict[float, float] = {}
        levels: dict[float, float] = {}
        differences = self.discrepancies()
        for data in self.problem.data:
            _, delay, level = differences[data.name]
            for index, f in enumerate(data.centres):
                inside = data.burst == index
                for worst, values in ((delays, delay), (levels, level)):
                    mean = float(np.mean(values[inside]))
                    worst[float(f)] = max(worst.get(float(f), 0.0), mean, key=abs)
        return delays, levels

    @property
    def explained(self) -> bool:
        """Whether chance explains the misfit, whatever becomes of what is stated."""
        return self.p_value > SIGNIFICANT

    @cached_property
    def _statements(self) -> tuple[tuple[Parameter, ...], RealArray, RealArray]:
        """What is stated, its coordinates and their covariance in the most probable solution, deviations included.

        A law by itself may drag them along for no other reason than that it is not quite the material's.
        """
        likely = self.laws.likeliest
        parameters, first = likely.problem.nuisances.parameters, len(likely.problem.modulus_parameters)
        own = slice(first, first + len(parameters))
        return parameters, likely.minima[0].z[own], likely.minima[0].covariance[own, own]

    @property
    def stated_p_value(self) -> float:
        """Probability that chance takes what the laboratory states for as far off, one of it or all of it together."""
        return pulls_p_value(*self._statements[1:])

    @property
    def all_accepted(self) -> bool:
        """Whether all meet eq. (10), and neither the misfit nor what is taken for stated wrongly is beyond chance."""
        chance = min(self.p_value, self.stated_p_value)
        return chance > SIGNIFICANT and all(burst.accepted for burst in self.bursts)

    @property
    def remarks(self) -> list[str]:
        """What a reader should know of the whole, in sentences."""
        return [text for text in (self.remark, self.remark_on_laws, *super().remarks) if text]

    @property
    def remark(self) -> str:
        """What speaks against one law for all; empty when it explains all."""
        return "; ".join(text for text in (self._of_misfit(), self._of_statements()) if text)

    @property
    def remark_on_laws(self) -> str:
        """What the moduli's bands hold besides the law's own; empty where there is nothing to say."""
        sentences = []
        rows = self.laws.rows()
        if len(rows) > 1 and rows[0].probability < _DECIDED:
            listed = ", ".join(f"{row.law} {row.probability:.2g}" for row in rows if row.probability > _WORTH_TELLING)
            sentences.append(f"the data do not decide between the laws ({listed}); the bands hold what they leave open")
        if self.laws.departs() > _DECIDED and self.laws.widening == 1:
            other = "" if len(rows) > 1 else ", or find a better one with --law auto"
            sentences.append(
                f"the material departs from {rows[0].law}, its loss factor by about {100 * rows[0].deviation:.2g} %: "
                f"the bands of the moduli hold that, the law's parameters do not; take the moduli{other}"
            )
        if modes := self._of_modes():
            sentences.append(modes)
        if self.laws.widening > 1:
            sentences.append(
                f"deviations and bands of the moduli are {self.laws.widening:.2g} times as wide as noise and what is "
                "stated make them: by the root of chi-square per datum that no departure from a law explains"
            )
        return "; ".join(sentences)

    def _of_modes(self) -> str:
        """Say which solutions the data cannot tell apart, at the frequency where they differ most."""
        at = np.unique(np.concatenate([data.centres for data in self.problem.data]))
        if not (modes := self.laws.far_modes(at)):
            return ""
        e1 = np.array([modulus.real for _, modulus in modes])
        place = int(np.argmax(np.ptp(np.log(e1), axis=0)))
        listed = " or ".join(f"{e1[row, place]:.3g} Pa ({share:.2g})" for row, (share, _) in enumerate(modes))
        return (
            f"several solutions are left open (probability): E1 at {at[place]:g} Hz is {listed}; the moduli are means "
            "over these, the parameters those of the best: add bursts of other frequencies or of another height"
        )

    def _of_misfit(self) -> str:
        if self.explained:
            return ""
        likely, law = self.laws.likeliest, ""
        if likely.share and likely.p_value > SIGNIFICANT:
            other = "" if len(self.laws.rows()) > 1 else " (find a better law with --law auto)"
            law = f"a loss factor {100 * likely.share:.2g} % off that of {likely.name} would{other}, or "
        return (
            f"one law does not explain all bursts within what is stated: chi-square {self.best.cost:.4g} for "
            f"{self.n_data} data; {law}something acts that this model lacks"
        )

    def _of_statements(self) -> str:
        if self.stated_p_value > SIGNIFICANT:
            return ""
        parameters, z, covariance = self._statements
        off = "; ".join(pull.beside_chance for pull in largest_pulls(parameters, z, spreads_by_chance(covariance)))
        return (
            "this takes what the laboratory states for wrong, which has the probability "
            f"{self.stated_p_value:.1g}: {off}. Correct the statement, or find the cause: "
            f"multilayer diagnose {self.campaign}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {**super().to_dict(), "modulus_intervals": modulus_intervals(self)}

    def contents(self) -> dict[str, Any]:
        """Return what `to_dict` has of this kind of fit."""
        return {
            "law": self.law.model_dump(mode="json"),
            **({"with": [effect.name for effect in self.problem.given]} if self.problem.given else {}),
            "parameters": {name: {"value": v, "std": s} for name, (v, s) in self.parameters.items()},
            "chi_square": self.best.cost,
            "n_data": self.n_data,
            "p_value": self.p_value,
            "stated_p_value": self.stated_p_value,
            "stated_deviations": {
                parameter.name: float(off) for parameter, off in zip(*self._statements[:2], strict=True)
            },
            "remark": self.remark,
            "laws": self.laws.to_dict(),
            "remark_on_laws": self.remark_on_laws,
            "moduli": self.rows(),
            "minima": [
                {"chi_square": m.cost, "log_evidence": m.log_evidence, "law": self._law_of(m).model_dump(mode="json")}
                for m in self.minima
            ],
        }

    def _law_of(self, minimum: Minimum) -> ModulusLaw:
        return self.problem.space.law(self.problem.law_coordinates(minimum.z))
