"""What comes over the wire, typed. Everything keeps the JSON that it was made from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .errors import NotMeasured, Withheld

FINAL = frozenset({"succeeded", "failed", "cancelled"})


@dataclass(frozen=True)
class Problem:
    """One mistake of a scene, or something odd about it."""

    pointer: str
    message: str
    value: Any = None
    limit: str | None = None
    remedy: str | None = None

    @classmethod
    def of(cls, body: dict[str, Any]) -> Problem:
        return cls(body["pointer"], body["message"], body.get("value"), body.get("limit"), body.get("remedy"))

    def __str__(self) -> str:
        parts = [f"{self.pointer or '/'}: {self.message}", self.limit and f"(limit {self.limit})", self.remedy and f"– {self.remedy}"]
        return " ".join(part for part in parts if part)


@dataclass(frozen=True)
class Job:
    """A job as it stood when it was asked for."""

    id: str
    name: str
    state: str
    progress: float
    simulated_time_s: float
    end_time_s: float
    failure: dict[str, Any] | None
    body: dict[str, Any]

    @classmethod
    def of(cls, body: dict[str, Any]) -> Job:
        names = ("id", "name", "state", "progress", "simulated_time_s", "end_time_s", "failure")
        return cls(**{name: body[name] for name in names}, body=body)

    @property
    def is_final(self) -> bool:
        return self.state in FINAL


@dataclass(frozen=True)
class Mesh:
    """An uploaded mesh; `body` has its parts, sets, box and, unless it is a scan or a surface, quality."""

    id: str
    format: str
    bytes: int
    body: dict[str, Any]

    @classmethod
    def of(cls, body: dict[str, Any]) -> Mesh:
        return cls(body["id"], body["format"], body["bytes"], body)


@dataclass(frozen=True)
class Progress:
    """How far a job is."""

    phase: str
    progress: float
    step: int
    simulated_time_s: float
    eta_s: float | None


@dataclass(frozen=True)
class Quantity:
    """A number of the summary with its estimated numerical error; `error` is None where it was not estimated."""

    value: float
    unit: str
    error: float | None
    is_resolved: bool | None

    @classmethod
    def of(cls, body: dict[str, Any], unit: str) -> Quantity:
        error = body["error"]
        if not isinstance(error, dict):
            return cls(body["value"], unit, None, None)
        return cls(body["value"], unit, error["total"], error["resolved"])

    def __str__(self) -> str:
        if self.error is None:
            return f"({self.value:.4g}) {self.unit}: error not estimated"
        if not self.is_resolved:
            return f"({self.value:.4g}) ± {self.error:.2g} {self.unit}: not resolved"
        return f"{self.value:.4g} ± {self.error:.2g} {self.unit}"


@dataclass(frozen=True)
class InjuryMeasure:
    """A published injury criterion: what it says of this run, and whether the experiments behind it cover this scene."""

    name: str
    title: str
    value: float | None
    unit: str
    applicable: bool
    statement: str
    missing: list[str]
    """Fields of the scene that the criterion needs and the scene lacks."""
    source: str
    body: dict[str, Any]

    @classmethod
    def of(cls, body: dict[str, Any]) -> InjuryMeasure:
        names = ("name", "title", "unit", "applicable", "statement", "source")
        return cls(
            **{name: body[name] for name in names},
            value=body.get("value"),
            missing=body.get("missing", []),
            body=body,
        )

    def __str__(self) -> str:
        return f"{self.title}: {self.statement} ({self.source})"


@dataclass(frozen=True)
class Summary:
    """The clinical summary. The four numbers are properties; everything else is in `body`."""

    body: dict[str, Any]

    @property
    def results(self) -> dict[str, Any]:
        """All numbers; raises `Withheld` when the run failed a gate."""
        if "withheld" in self.body:
            raise Withheld(self.body["withheld"]["reason"])
        results: dict[str, Any] = self.body["results"]
        return results

    @property
    def nothing_touched(self) -> bool:
        """Whether the run ended without an impact."""
        return bool(self.results.get("nothing_touched"))

    @property
    def impact(self) -> dict[str, Any]:
        """The hardest impact on the tissue, or of all where no tissue is hit; raises `NotMeasured` where nothing touched."""
        results = self.results
        if self.nothing_touched:
            raise NotMeasured("nothing touched: there was no impact")
        impacts = results["impacts"]
        named = results.get("headline", {}).get("impact")
        if named is not None:
            return dict(impacts[named])
        if not impacts:
            raise NotMeasured("the scene has no contact, so there is no impact")
        on_tissue = [impact for impact in impacts if impact["on_tissue"]]
        hardest: dict[str, Any] = max(on_tissue or impacts, key=lambda impact: impact["peak_force_n"]["value"])
        return hardest

    @property
    def tissue(self) -> dict[str, Any]:
        """What became of the tissue; raises `NotMeasured` where the scene has none, or nothing touched."""
        if self.nothing_touched:
            raise NotMeasured("nothing touched: there was no impact")
        tissue: dict[str, Any] | None = self.results.get("tissue")
        if tissue is None:
            raise NotMeasured("the scene has no body of role `tissue`")
        return tissue

    @property
    def peak_force_n(self) -> Quantity:
        return Quantity.of(self.impact["peak_force_n"], "N")

    @property
    def force_average(self) -> str:
        """What the peak force is averaged over, or filtered by."""
        words: str = self.impact["force_average"]
        return words

    @property
    def law_ranges(self) -> list[dict[str, Any]]:
        """Parts whose law was used beyond its fitted range."""
        ranges: list[dict[str, Any]] = self.body.get("law_ranges", [])
        return ranges

    @property
    def law_rates(self) -> list[dict[str, Any]]:
        """Strain rates of parts, and those of their tests where the source gives them."""
        rates: list[dict[str, Any]] = self.body.get("law_rates", [])
        return rates

    @property
    def softening(self) -> list[dict[str, Any]]:
        """Parts that exceeded their strength: the softened and the torn volume, and since when."""
        parts: list[dict[str, Any]] = self.body.get("softening", [])
        return parts

    @property
    def erosion(self) -> list[dict[str, Any]]:
        """Parts that lost elements: how many, their volume and mass, and since when."""
        parts: list[dict[str, Any]] = self.body.get("erosion", [])
        return parts

    @property
    def largest_patch_area_mm2(self) -> Quantity:
        return Quantity.of(self.impact["largest_patch_area_mm2"], "mm²")

    @property
    def patch_area_mm2(self) -> Quantity:
        return Quantity.of(self.impact["patch_area_mm2"], "mm²")

    @property
    def energy_given_j(self) -> Quantity:
        return Quantity.of(self.tissue["energy_given_j"], "J")

    @property
    def absorbed_energy_j(self) -> Quantity:
        return Quantity.of(self.tissue["absorbed_energy_j"], "J")

    @property
    def depths_mm(self) -> dict[float, Quantity]:
        """Depth of von Mises stress above each threshold [Pa], where the scene has a surface to measure it from."""
        depths = self.tissue["significant_stress"]
        return {depth["threshold_pa"]: Quantity.of(depth["depth_mm"], "mm") for depth in depths if depth.get("depth_mm")}

    @property
    def principal_strain_in_volume(self) -> tuple[float, Quantity] | None:
        """A volume [mm³] and the principal strain exceeded in it; none where the laws do not hold there, or there is less tissue."""
        exceeded = self.tissue.get("exceeded_in_volume")
        return exceeded and (exceeded["volume_mm3"], Quantity.of(exceeded["principal_strain"], "-"))

    @property
    def mps95(self) -> dict[str, Quantity]:
        """95th percentile by volume of the principal strain of each part of the tissue."""
        parts = self.tissue["percentiles"]
        return {part["part"]: Quantity.of(part["mps95"], "-") for part in parts if part.get("mps95")}

    @property
    def warnings(self) -> list[str]:
        warnings: list[str] = self.body["warnings"]
        return warnings

    @property
    def plain_words(self) -> list[str]:
        """The numbers in plain words, with their doubts."""
        words: list[str] = self.body["plain_words"]
        return words

    @property
    def injury_measures(self) -> list[InjuryMeasure]:
        """Published injury criteria; none of them is a diagnosis."""
        return [InjuryMeasure.of(measure) for measure in self.body["injury_measures"]]

    @property
    def notice(self) -> str:
        """What the results are not."""
        notice: str = self.body["notice"]
        return notice
