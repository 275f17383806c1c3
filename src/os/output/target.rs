use std::{
    ffi::OsStr,
    fmt,
    io::{self, IsTerminal},
    path::{Path, PathBuf},
};

/// A file that holds all frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// A PNG; with several frames an animated one (APNG), which programs that know only PNG show as its first frame.
    Png,
    /// A GIF: 255 colours, dithered. Browsers play more than 50 frames a second slowly.
    Gif,
    /// A lossless WebP.
    WebP,
    /// Uncompressed video (YUV4MPEG2) for ffmpeg, mpv and other programs.
    Y4m,
}

impl FileFormat {
    /// Every format.
    pub const ALL: [Self; 4] = [Self::Png, Self::Gif, Self::WebP, Self::Y4m];

    /// The extensions of file names, as people type them after `--out`.
    const EXTENSIONS: [(&'static str, Self); 5] = [
        ("apng", Self::Png),
        ("png", Self::Png),
        ("gif", Self::Gif),
        ("webp", Self::WebP),
        ("y4m", Self::Y4m),
    ];

    fn from_extension(extension: &OsStr) -> Option<Self> {
        let known = Self::EXTENSIONS.iter().find(|(name, _)| extension.eq_ignore_ascii_case(name));
        known.map(|(_, format)| *format)
    }
}

/// Where frames go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// One file.
    File {
        /// Its name.
        path: PathBuf,
        /// What is written into it.
        format: FileFormat,
    },
    /// A folder of `frame_00000.png`, `frame_00001.png` and so on. It may be new, empty, or hold the frames of an earlier run,
    /// which are replaced.
    Folder(PathBuf),
    /// Standard output, as [`FileFormat::Y4m`].
    Stdout,
}

/// A word that names no place for frames: a usage error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TargetError {
    /// No name.
    Empty,
    /// A file name whose extension is none of those that can be written.
    Extension(PathBuf),
    /// Standard output is a terminal, which video would garble.
    Terminal,
}

impl Target {
    /// The place that the word after `--out` names: `-` is stdout; an existing folder, a name that ends in `/` and one without
    /// extension are folders; everything else is a file whose extension says the format.
    ///
    /// # Errors
    ///
    /// An extension that is not known, `-` when stdout is a terminal, or no name.
    pub fn parse(word: &OsStr) -> Result<Self, TargetError> {
        let path = Path::new(word);
        match word.as_encoded_bytes() {
            b"" => Err(TargetError::Empty),
            b"-" if io::stdout().is_terminal() => Err(TargetError::Terminal),
            b"-" => Ok(Self::Stdout),
            [.., b'/'] => Ok(Self::Folder(path.into())),
            _ => Self::of_path(path),
        }
    }

    fn of_path(path: &Path) -> Result<Self, TargetError> {
        let Some(extension) = path.extension().filter(|_| !path.is_dir()) else {
            return Ok(Self::Folder(path.into()));
        };
        let format =
            FileFormat::from_extension(extension).ok_or_else(|| TargetError::Extension(path.into()))?;
        Ok(Self::File { path: path.into(), format })
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { path, .. } | Self::Folder(path) => path.display().fmt(f),
            Self::Stdout => f.write_str("standard output"),
        }
    }
}

impl fmt::Display for TargetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => {
                return f.write_str("no name to write to; name a file, a folder, or - for standard output");
            }
            Self::Terminal => {
                return f
                    .write_str("standard output is a terminal; add | ffmpeg -i - out.mp4 or name a file");
            }
            Self::Extension(path) => write!(f, "{}: unknown extension; the known ones are ", path.display())?,
        }
        for (i, (extension, _)) in FileFormat::EXTENSIONS.iter().enumerate() {
            write!(f, "{}.{extension}", if i == 0 { "" } else { ", " })?;
        }
        f.write_str("; a name without extension is a folder")
    }
}

impl std::error::Error for TargetError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(word: &str) -> Result<Target, TargetError> {
        Target::parse(OsStr::new(word))
    }

    #[test]
    fn the_extension_says_the_format() {
        for (word, format) in [
            ("a.png", FileFormat::Png),
            ("a.apng", FileFormat::Png),
            ("dir.d/a b.GIF", FileFormat::Gif),
            ("a.tar.webp", FileFormat::WebP),
            ("/x/a.y4m", FileFormat::Y4m),
        ] {
            assert_eq!(parse(word), Ok(Target::File { path: word.into(), format }));
        }
    }

    #[test]
    fn names_without_extension_and_existing_folders_are_folders() {
        let existing = tempfile::Builder::new().suffix(".gif").tempdir().unwrap();
        for word in ["frames", "out/", "a.gif/", ".", "..", ".hidden", existing.path().to_str().unwrap()] {
            assert_eq!(parse(word), Ok(Target::Folder(word.into())), "{word}");
        }
    }

    #[test]
    fn an_unknown_extension_is_refused_with_the_list_of_known_ones() {
        let text = parse("film.mp4").unwrap_err().to_string();
        assert!(text.starts_with("film.mp4: unknown extension"), "{text}");
        for (extension, _) in FileFormat::EXTENSIONS {
            assert!(text.contains(&format!(".{extension}")), "{text}");
        }
        assert_eq!(parse(""), Err(TargetError::Empty));
    }
}
