//! Paths as a scene file names them.

use std::path::{Component, Path, PathBuf};

/// `file` as seen from the folder `dir`: relative where both have a root in common, so that they can move together.
pub(super) fn relative(dir: &Path, file: &Path) -> PathBuf {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (dir, file) = (absolute(dir), absolute(file));
    let (from, to): (Vec<Component>, Vec<Component>) =
        (dir.components().collect(), file.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    // A link on the way, or a step up, would lead elsewhere.
    let is_plain = |parts: &[Component]| parts.iter().all(|part| matches!(part, Component::Normal(_)));
    if shared < 2 || !is_plain(&from[shared..]) || !is_plain(&to[shared..]) {
        return file;
    }
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    up.chain(to[shared..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_below_beside_and_elsewhere_are_named() {
        let of =
            |dir: &str, file: &str| relative(Path::new(dir), Path::new(file)).to_string_lossy().into_owned();
        assert_eq!(of("/data/pond", "/data/pond/clear.png"), "clear.png");
        assert_eq!(of("/data/pond", "/data/raw/clear.png"), "../raw/clear.png");
        assert_eq!(of("/data/pond", "/home/clear.png"), "/home/clear.png");
        assert_eq!(of("/data/../data/pond", "/data/clear.png"), "/data/clear.png");
    }
}
