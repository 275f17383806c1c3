//! The sidecar of a photo: a file beside it that says how this one photo is shown.

use super::{
    config::Look,
    config_file,
    document::{ConfigError, Document, read_text},
};
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

/// The sidecar of the photo at `photo`, if there is one. As with masks, `lake.jpg.toml` goes before `lake.toml`, which also serves
/// a `lake.png`.
pub fn path(photo: &Path) -> Option<PathBuf> {
    paths(photo).into_iter().find(|path| path.exists())
}

/// Where the sidecar of the photo at `photo` may be, that which goes before first.
pub(super) fn paths(photo: &Path) -> [PathBuf; 2] {
    let mut longer = OsString::from(photo);
    longer.push(".toml");
    [longer.into(), photo.with_extension("toml")]
}

/// What the sidecar of the photo at `photo` makes of `look`; `None` where there is no sidecar.
pub(super) fn load(photo: &Path, look: &Look) -> Result<Option<Look>, ConfigError> {
    let Some(path) = path(photo) else { return Ok(None) };
    let text = read_text(&path)?;
    parse(&path, &text, look).map(Some)
}

/// What the `text` of the sidecar at `path` makes of `look`. It has the keys of the configuration's section `life`, of photos
/// `fit` and `seconds`, and no sections. Paths in it start from its folder.
///
/// # Errors
/// Every mistake in it, with its line and column.
pub fn parse(path: &Path, text: &str, look: &Look) -> Result<Look, ConfigError> {
    let name = path.display().to_string();
    let mut look = look.clone();
    let mut parsed = Document::parse(&name, text)?;
    let document = &mut parsed;
    config_file::life(document, "", &mut look, path.parent().unwrap_or(Path::new("")));
    config_file::shown(document, "", &mut look);
    parsed.finish()?;
    Ok(look)
}
