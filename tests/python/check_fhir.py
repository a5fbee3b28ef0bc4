#!/usr/bin/env python3
"""Checks a FHIR bundle of `contuse export --fhir` against the models of FHIR R4B, and what models do not say.

    check_fhir.py BUNDLE.json
"""

import json
import sys

from fhir.resources.R4B.bundle import Bundle

UCUM = {"N", "N.s", "s", "mm", "mm2", "mm3", "J", "Pa", "1", "J/m3", "J/cm2", "m/s"}


def check(path: str) -> list[str]:
    with open(path, encoding="utf-8") as file:
        text = file.read()
    # Every resource of the bundle is checked as what it says that it is; unknown members are errors.
    bundle = Bundle.model_validate_json(text)
    assert bundle.type == "collection"
    entries = json.loads(text)["entry"]
    urls = [entry["fullUrl"] for entry in entries]
    assert len(set(urls)) == len(urls), "every resource has its own name"
    kinds = [entry["resource"]["resourceType"] for entry in entries]
    assert kinds.count("Device") == 1 and kinds.count("Provenance") == 1
    seen = []
    for entry in entries:
        resource = entry["resource"]
        if resource["resourceType"] == "Provenance":
            assert all(target["reference"] in urls for target in resource["target"])
        if resource["resourceType"] != "Observation":
            continue
        code = resource["code"]["coding"][0]
        assert code["system"] == "urn:contuse:observation", "no codes of other systems"
        assert resource["device"]["reference"] in urls
        assert resource["focus"][0]["identifier"]["value"] and resource["category"]
        assert "effectiveDateTime" not in resource, "a recording has simulated times only"
        values = {"valueQuantity", "valueString", "dataAbsentReason"} & resource.keys()
        assert len(values) == 1, values
        assert resource["status"] == "preliminary" or "dataAbsentReason" not in resource or not resource.get("component"), "final without a value"
        quantities = [resource.get("valueQuantity"), *(c.get("valueQuantity") for c in resource.get("component", []))]
        for quantity in filter(None, quantities):
            assert quantity["system"] == "http://unitsofmeasure.org" and quantity["code"] in UCUM, quantity
        seen.append(code["code"])
    assert {"peak-force", "contact-patch-area", "absorbed-energy"} <= set(seen), seen
    return seen


if __name__ == "__main__":
    print(f"{sys.argv[1]}: {len(check(sys.argv[1]))} observations, a valid FHIR R4 collection")
