//! A set of results is whole.

use super::workshop::{SCENE, Workshop};
use sha2::{Digest, Sha256};
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::Path;

const FIT: &str = "fit scene.toml --model small-angle --out result";

fn hash(path: &Path) -> Option<String> {
    let bytes = fs::read(path).ok()?;
    Some(Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Whether the report in `folder` is there, and the files that it names are as it says.
pub fn is_whole(folder: &Path) -> bool {
    let report = fs::read(folder.join("fit.json")).ok();
    let report = report.and_then(|json| serde_json::from_slice::<serde_json::Value>(&json).ok());
    let Some(files) = report.as_ref().and_then(|report| report["files"].as_object()) else { return false };
    files.len() >= 7 && files.iter().all(|(name, said)| said.as_str() == hash(&folder.join(name)).as_deref())
}

fn observed() -> Workshop {
    let shop = Workshop::new();
    shop.observe(SCENE);
    shop
}

fn succeeds(shop: &Workshop, arguments: &str) {
    let run = shop.run(arguments);
    assert_eq!(run.code, 0, "{arguments}: {}", run.stderr);
}

/// Names in `result` that no set of one scene without hidden light has.
fn others(shop: &Workshop) -> Vec<String> {
    let ours =
        ["fit.json", "fit.png", "object.png", "observed.png", "render.exr", "render.png", "residual.exr"];
    let is_ours = |name: &String| ours.contains(&name.as_str()) || name == "residual.png";
    shop.names("result").into_iter().filter(|name| !is_ours(name)).collect()
}

#[test]
fn a_report_names_its_files_and_where_it_comes_from() {
    let shop = observed();
    succeeds(&shop, FIT);
    assert!(is_whole(&shop.file("result")));
    let report: serde_json::Value = serde_json::from_slice(&shop.bytes("result/fit.json")).unwrap();
    assert_eq!(report["files"].as_object().unwrap().len() + 1, shop.names("result").len());
    let from = &report["provenance"];
    let arguments: Vec<&str> = std::iter::once("narrowbeam").chain(FIT.split(' ')).collect();
    assert_eq!(from["arguments"], serde_json::json!(arguments));
    assert_eq!(
        (&from["settings"]["model"], &from["settings"]["solver"]),
        (&report["model"], &"levenberg-marquardt".into())
    );
    assert_eq!(from["seed"], 1);
    let here = fs::canonicalize(shop.file(".")).unwrap();
    assert_eq!(fs::canonicalize(from["working_directory"].as_str().unwrap()).unwrap(), here);
    humantime::parse_rfc3339(from["date"].as_str().unwrap()).unwrap();
    let inputs = from["inputs"].as_array().unwrap();
    let names: Vec<&str> = inputs.iter().map(|input| input["path"].as_str().unwrap()).collect();
    assert_eq!(names, ["scene.toml", "object.exr", "observed.exr"]);
    for (input, name) in inputs.iter().zip(names) {
        assert_eq!(input["sha256"].as_str(), hash(&shop.file(name)).as_deref());
    }
}

#[test]
fn a_set_that_is_not_whole_is_told() {
    let shop = observed();
    succeeds(&shop, FIT);
    let render = shop.bytes("result/render.exr");
    for spoil in ["result/render.exr", "result/fit.png"] {
        shop.write(spoil, "other");
        assert!(!is_whole(&shop.file("result")), "{spoil}");
        fs::remove_file(shop.file(spoil)).unwrap();
        assert!(!is_whole(&shop.file("result")), "{spoil}");
        succeeds(&shop, FIT);
        assert!(is_whole(&shop.file("result")));
    }
    assert_eq!(shop.bytes("result/render.exr"), render, "identical runs have identical images");
    assert!(!is_whole(&shop.file(".")));
}

#[test]
fn a_folder_of_ours_is_replaced_in_one_step_and_keeps_its_permissions() {
    let shop = observed();
    let number = || fs::metadata(shop.file("result")).unwrap().ino();
    succeeds(&shop, &FIT.replace("result", "new/result"));
    succeeds(&shop, FIT);
    fs::set_permissions(shop.file("result"), fs::Permissions::from_mode(0o700)).unwrap();
    let first = number();
    succeeds(&shop, FIT);
    assert_ne!(number(), first);
    assert_eq!(fs::metadata(shop.file("result")).unwrap().mode() & 0o777, 0o700);
    // Not one that holds something else.
    shop.write("result/notes.txt", "mine");
    let second = number();
    succeeds(&shop, FIT);
    assert_eq!((number(), shop.bytes("result/notes.txt")), (second, b"mine".to_vec()));
    assert!(is_whole(&shop.file("result")));
    assert_eq!(shop.names("."), ["new", "object.exr", "observed.exr", "result", "scene.toml"]);
}

#[test]
fn what_an_earlier_fit_has_left_goes_and_what_is_not_its_own_stays() {
    let shop = observed();
    shop.write("far.toml", &SCENE.replace("depth = 2.0", "depth = 3.0"));
    fs::rename(shop.file("observed.exr"), shop.file("near.exr")).unwrap();
    succeeds(&shop, "render far.toml --model small-angle --output far.exr");
    shop.write("far.toml", &SCENE.replace("depth = 2.0", "depth = 3.0").replace("observed", "far"));
    shop.write("scene.toml", &SCENE.replace("observed", "near"));
    let both = FIT.replace("scene.toml", "scene.toml far.toml");
    for (notes, changed, left) in [
        (false, false, vec![]),
        (true, false, vec!["notes.txt"]),
        (true, true, vec!["notes.txt", "render-2.exr"]),
    ] {
        let _ = fs::remove_dir_all(shop.file("result"));
        succeeds(&shop, &both);
        assert!(shop.file("result/render-2.exr").exists());
        if notes {
            shop.write("result/notes.txt", "mine");
        }
        if changed {
            shop.write("result/render-2.exr", "mine");
        }
        // A report speaks of its own folder alone.
        let report = String::from_utf8(shop.bytes("result/fit.json")).unwrap();
        let hash = hash(&shop.file("near.exr")).unwrap();
        shop.write(
            "result/fit.json",
            &report.replace("\"files\": {", &format!("\"files\": {{ \"../near.exr\": \"{hash}\",")),
        );
        succeeds(&shop, FIT);
        assert_eq!(others(&shop), left);
        assert!(is_whole(&shop.file("result")) && shop.file("near.exr").exists());
    }
}

#[test]
fn the_current_folder_and_a_link_get_a_whole_set_too() {
    let shop = observed();
    succeeds(&shop, &FIT.replace("result", "."));
    assert!(is_whole(&shop.file(".")));
    assert_eq!(shop.names(".").len(), 11);
    fs::create_dir(shop.file("result")).unwrap();
    symlink("result", shop.file("link")).unwrap();
    for _ in 0..2 {
        succeeds(&shop, &FIT.replace("result", "link"));
        assert!(
            fs::symlink_metadata(shop.file("link")).unwrap().is_symlink() && is_whole(&shop.file("result"))
        );
    }
    // And a link in a folder is followed.
    shop.write("elsewhere.exr", "old");
    fs::remove_file(shop.file("result/render.exr")).unwrap();
    symlink("../elsewhere.exr", shop.file("result/render.exr")).unwrap();
    succeeds(&shop, FIT);
    assert!(fs::symlink_metadata(shop.file("result/render.exr")).unwrap().is_symlink());
    assert!(is_whole(&shop.file("result")) && shop.bytes("elsewhere.exr") != b"old");
    assert_eq!(others(&shop), [""; 0]);
}

#[test]
fn a_full_disk_leaves_what_was_there() {
    let shop = observed();
    let full = |command: &str| format!("trap '' XFSZ; ulimit -f 4; exec narrowbeam {command}");
    let render = "render scene.toml --output out.exr";
    for (command, files) in [(FIT, "result"), (render, "out.exr")] {
        let run = shop.shell(&full(command));
        assert_eq!(run.code, 1, "{}", run.stderr);
        assert!(run.stderr.contains(files) && run.stderr.contains("free some space"), "{}", run.stderr);
        assert!(!run.stderr.contains(".part"), "{}", run.stderr);
        assert_eq!(shop.names("."), ["object.exr", "observed.exr", "scene.toml"]);
    }
    succeeds(&shop, FIT);
    let report = shop.bytes("result/fit.json");
    for folder in ["result", "result/../result", "."] {
        assert_eq!(shop.shell(&full(&FIT.replace("result", folder))).code, 1);
        assert!(is_whole(&shop.file("result")) && shop.bytes("result/fit.json") == report);
        assert_eq!(shop.names("."), ["object.exr", "observed.exr", "result", "scene.toml"]);
    }
}
