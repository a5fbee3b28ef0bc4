"""Checks the packages that the program is made of, and writes its software bill of materials (CycloneDX 1.6, JSON).

    python tests/python/check_packages.py BOM.json

Every package comes from crates.io, under a licence that allows to link it. Prints their number and exits with 1 and all reasons otherwise.
"""

import json
import pathlib
import subprocess
import sys

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.contrib.this.builders import this_component
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from license_expression import get_spdx_licensing
from packageurl import PackageURL

CRATES_IO = "registry+https://github.com/rust-lang/crates.io-index"
# Without duties for those who link; MPL and Unicode ask to keep their notices.
ALLOWED = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CDLA-Permissive-2.0", "ISC", "MIT",
    "MPL-2.0", "Unicode-3.0", "Unlicense", "Zlib",
}


def packages() -> list[dict]:
    """The packages of the lock file that the program itself is compiled from, with all features, on this platform."""
    root = pathlib.Path(__file__).resolve().parents[2]
    host = next(line.split()[1] for line in subprocess.check_output(["rustc", "-vV"], text=True).splitlines() if line.startswith("host:"))
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features", "--filter-platform", host]
    metadata = json.loads(subprocess.check_output(command, cwd=root))
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    found, waiting = set(), list(metadata["workspace_members"])
    while waiting:
        package = waiting.pop()
        if package not in found:
            found.add(package)
            kept = [d for d in nodes[package]["deps"] if any(kind["kind"] != "dev" for kind in d["dep_kinds"])]
            waiting.extend(dependency["pkg"] for dependency in kept)
    return [package for package in metadata["packages"] if package["id"] in found]


def is_allowed(expression: str) -> bool:
    """Whether one choice of an SPDX expression has allowed licences only."""
    licensing = get_spdx_licensing()
    parsed = licensing.parse(expression.replace("/", " OR "), validate=True)
    allowed = {symbol: licensing.TRUE for symbol in parsed.symbols if str(symbol) in ALLOWED}
    others = {symbol: licensing.FALSE for symbol in parsed.symbols if str(symbol) not in ALLOWED}
    return parsed.subs({**allowed, **others}, simplify=True) == licensing.TRUE


def faults(package: dict) -> list[str]:
    """What is wrong with a package."""
    name = f"{package['name']} {package['version']}"
    wrong = []
    if package["source"] not in (None, CRATES_IO):
        wrong.append(f"{name} is from {package['source']}")
    if not package["license"] or not is_allowed(package["license"]):
        wrong.append(f"{name} has the licence {package['license']}")
    return wrong


def bill(all_packages: list[dict]) -> Bom:
    """The packages as a bill of materials."""
    bom, licenses = Bom(), LicenseFactory()
    bom.metadata.tools.components.add(this_component())
    for package in all_packages:
        url = PackageURL("cargo", None, package["name"], package["version"])
        bom.components.add(Component(
            name=package["name"], version=package["version"], type=ComponentType.LIBRARY, purl=url, bom_ref=str(url),
            licenses=[licenses.make_from_string(package["license"].replace("/", " OR "))],
        ))
    return bom


def main(path: str) -> int:
    """Checks all, and writes the bill."""
    all_packages = packages()
    wrong = [fault for package in all_packages for fault in faults(package)]
    if wrong:
        print("\n".join(wrong))
        return 1
    JsonV1Dot6(bill(all_packages)).output_to_file(path, allow_overwrite=True, indent=1)
    print(f"{len(all_packages)} packages, all from crates.io or from here, under licences that allow to link them")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
