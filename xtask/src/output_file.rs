//! Files that commands read and write: outputs are either whole or absent.
//!
//! A command that computes for minutes asks [`check_writable`] first, so that a misspelt folder fails at once; what
//! it computed then goes to a temporary file in the same folder and takes its name only when it is complete.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::{Failure, Outcome};

/// Fails when `path` cannot be written, and leaves nothing behind either way.
pub(crate) fn check_writable(path: &Path) -> Outcome {
    let target = resolve(path);
    if target.is_dir() {
        return Err(Failure::input(format_args!("{}: is a folder, not a file", path.display())));
    }
    if target.exists() {
        // a rename would replace a file that its owner made read-only; opening it asks and changes nothing
        OpenOptions::new().append(true).open(&target).map_err(|error| unwritable(path, &error))?;
    }
    if is_special(&target) {
        return Ok(());
    }
    // the file is removed when it goes out of scope
    temporary_beside(&target).map_err(|error| unwritable(path, &error))?;
    Ok(())
}

/// A file that is complete beside its place and only has to take its name.
#[derive(Debug)]
pub(crate) struct Staged {
    path: PathBuf,
    target: PathBuf,
    /// Absent for a device or pipe, which was written to at once.
    temporary: Option<NamedTempFile>,
}

impl Staged {
    /// Gives the file its name. After this an older file of that name is gone.
    pub(crate) fn commit(self) -> Outcome {
        let Some(temporary) = self.temporary else { return Ok(()) };
        temporary.persist(&self.target).map(drop).map_err(|error| unwritable(&self.path, &error.error))
    }
}

/// Writes `bytes` beside `path`; what belongs together is staged first and committed when all of it is there.
///
/// On an error the folder is as it was, an older file of that name included.
pub(crate) fn stage(path: &Path, bytes: &[u8]) -> Outcome<Staged> {
    stage_with(path, |file| file.write_all(bytes))
}

fn stage_with<W>(path: &Path, fill: W) -> Outcome<Staged>
where
    W: FnOnce(&mut BufWriter<File>) -> io::Result<()>,
{
    let target = resolve(path);
    let write = || {
        if is_special(&target) {
            // a device or pipe (such as /dev/stdout) must be written to, never replaced
            let file = OpenOptions::new().write(true).open(&target)?;
            return fill_and_flush(file, fill).map(|_| None);
        }
        let temporary = temporary_beside(&target)?;
        fill_and_flush(temporary.as_file().try_clone()?, fill)?;
        Ok(Some(temporary))
    };
    let temporary = write().map_err(|error: io::Error| unwritable(path, &error))?;
    Ok(Staged { path: path.to_owned(), target, temporary })
}

/// Writes a file whole or not at all; see [`stage`].
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Outcome {
    stage(path, bytes)?.commit()
}

/// Fails when two of the files of one command are the same: an output would replace an input or another output.
pub(crate) fn check_distinct(files: &[(&str, &Path)]) -> Outcome {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::canonicalize(path).or_else(|_| {
            Ok::<_, io::Error>(fs::canonicalize(folder)?.join(path.file_name().unwrap_or_default()))
        })
    };
    for (i, (name, path)) in files.iter().enumerate() {
        for (other_name, other) in &files[..i] {
            if let (Ok(a), Ok(b)) = (place(path), place(other))
                && a == b
                && !is_special(&a)
            {
                return Err(Failure::input(format_args!(
                    "{}: is both {other_name} and {name}",
                    path.display()
                )));
            }
        }
    }
    Ok(())
}

/// A whole input file; anything but a regular file could be endless.
pub(crate) fn read_input(path: &Path) -> Outcome<Vec<u8>> {
    let read = || {
        if !fs::metadata(path)?.is_file() {
            return Err(io::Error::other("not a regular file"));
        }
        fs::read(path)
    };
    read().map_err(|error: io::Error| Failure::input(format_args!("{}: {error}", path.display())))
}

/// `into_inner` reports what a dropped `BufWriter` would swallow.
fn fill_and_flush<W>(file: File, fill: W) -> io::Result<File>
where
    W: FnOnce(&mut BufWriter<File>) -> io::Result<()>,
{
    let mut buffered = BufWriter::new(file);
    fill(&mut buffered)?;
    buffered.into_inner().map_err(io::IntoInnerError::into_error)
}

fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".unfinished-");
    // temporary files are private by default; the finished file is to follow the user's umask like any other
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Follows a symbolic link, so that the link stays and its target is replaced.
fn resolve(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

fn is_special(target: &Path) -> bool {
    fs::metadata(target).is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    // the temporary file's own name would only confuse
    let reason = match error.kind() {
        io::ErrorKind::NotFound => "its folder does not exist".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => error.to_string(),
    };
    Failure::input(format_args!("{}: cannot be written: {reason}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn check_leaves_nothing_behind_and_keeps_an_older_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        check_writable(&path).unwrap();
        assert_eq!(names(folder.path()), [""; 0], "the folder must stay empty");

        fs::write(&path, "old").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn missing_folder_and_folder_as_file_are_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().join("absent/out.png"), folder.path().to_path_buf()] {
            let failure = check_writable(&path).unwrap_err();
            assert_eq!(failure.code(), 2);
            assert!(failure.to_string().contains(path.to_str().unwrap()), "{failure}");
        }
    }

    #[test]
    fn a_failed_write_keeps_the_older_file_and_no_rest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        write_bytes(&path, b"old").unwrap();
        let failed = stage_with(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out.txt"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_and_a_device_stay_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file.txt"), folder.path().join("link.txt"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_bytes(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");

        write_bytes(Path::new("/dev/null"), b"nothing").unwrap();
        assert!(is_special(Path::new("/dev/null")));
    }
}
