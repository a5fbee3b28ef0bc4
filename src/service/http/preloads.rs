//! Links in the page of the viewer to the modules that it imports, so that the browser fetches them at once, not each where it
//! finds the import.

use serde_json::Value;
use std::fmt::Write as _;

/// The modules that the page of a result begins with, and those of the picture, which it loads when its numbers are there, larger and less
/// urgent. The plots come after the picture.
const ENTRIES: [(&str, &str); 3] =
    [("app.js", ""), ("pages/job_page.js", ""), ("picture/run_panel.js", " fetchpriority=\"low\"")];

/// The page with the links; `source` gives the text of a module by its path in the folder of the viewer.
pub fn with_preloads(page: &str, source: impl Fn(&str) -> Option<String>) -> String {
    let map: Value = serde_json::from_str(import_map(page)).unwrap_or_default();
    let (mut links, mut known) = (String::new(), Vec::new());
    for (entry, priority) in ENTRIES {
        let first = known.len();
        collect(entry, &map["imports"], &source, &mut known);
        for name in &known[first..] {
            let _ = writeln!(links, "<link rel=\"modulepreload\"{priority} href=\"viewer/{name}\">");
        }
    }
    page.replacen("<script type=\"module\"", &format!("{links}<script type=\"module\""), 1)
}

/// The import map of a page, as JSON; empty if it has none.
pub fn import_map(page: &str) -> &str {
    let rest = page.split_once("<script type=\"importmap\">").map_or("", |(_, rest)| rest);
    rest.split_once("</script>").map_or("", |(map, _)| map)
}

/// Adds a module to the known ones, and all that it imports.
fn collect(name: &str, map: &Value, source: &impl Fn(&str) -> Option<String>, known: &mut Vec<String>) {
    if known.iter().any(|other| other == name) {
        return;
    }
    let Some(text) = source(name) else { return };
    known.push(name.to_owned());
    // `import … from "x"` and `export … from "x"`, with or without spaces; dynamic imports are `import("x")`.
    let specifiers = text.split("from").skip(1).filter_map(|after| after.trim_start().strip_prefix('"'));
    for specifier in specifiers.filter_map(|rest| Some(rest.split_once('"')?.0)) {
        match map[specifier].as_str() {
            Some(path) => collect(path.trim_start_matches("./viewer/"), map, source, known),
            None => collect(&beside(name, specifier), map, source, known),
        }
    }
}

/// The path of a module that another one imports by a relative path.
fn beside(importer: &str, relative: &str) -> String {
    let mut path: Vec<&str> = importer.split('/').collect();
    path.pop();
    for segment in relative.split('/') {
        match segment {
            "." => {}
            ".." => drop(path.pop()),
            name => path.push(name),
        }
    }
    path.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "<script type=\"importmap\">{\"imports\": {\"big\": \"./viewer/vendor/big.js\"}}</script>\n\
        <script type=\"module\" src=\"viewer/app.js\"></script>";

    #[test]
    fn what_is_imported_is_linked_once_and_pictures_last() {
        let source = |name: &str| {
            let text = match name {
                "app.js" => {
                    "import { a } from \"./api.js\"; const p = () => import(\"./pages/list_page.js\");"
                }
                "pages/job_page.js" => "import { a } from \"../api.js\";\nimport { b } from \"./part.js\";",
                "picture/run_panel.js" => "import*as T from\"big\"; import { b } from \"../pages/part.js\";",
                "api.js" | "pages/part.js" | "vendor/big.js" => "export const a = Array.from(\"x\");",
                _ => return None,
            };
            Some(text.to_owned())
        };
        let page = with_preloads(PAGE, source);
        let links: Vec<&str> = page.lines().filter(|line| line.starts_with("<link")).collect();
        let first = ["app.js", "api.js", "pages/job_page.js", "pages/part.js"]
            .map(|name| format!("<link rel=\"modulepreload\" href=\"viewer/{name}\">"));
        let then = ["picture/run_panel.js", "vendor/big.js"]
            .map(|name| format!("<link rel=\"modulepreload\" fetchpriority=\"low\" href=\"viewer/{name}\">"));
        assert_eq!(links, [&first[..], &then[..]].concat());
        assert!(page.ends_with("<script type=\"module\" src=\"viewer/app.js\"></script>"));
    }
}
