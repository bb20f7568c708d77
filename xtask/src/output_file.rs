//! Output files that are either whole or absent.
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

/// Writes a file through `fill`: to a temporary file in the same folder, then renamed.
///
/// On an error the folder is as it was, an older file of that name included.
pub(crate) fn write_atomically<W>(path: &Path, fill: W) -> Outcome
where
    W: FnOnce(&mut BufWriter<File>) -> io::Result<()>,
{
    let target = resolve(path);
    let result = if is_special(&target) {
        // a device or pipe (such as /dev/stdout) must be written to, never replaced
        OpenOptions::new().write(true).open(&target).and_then(|file| fill_and_flush(file, fill).map(drop))
    } else {
        write_beside(&target, fill)
    };
    result.map_err(|error| unwritable(path, &error))
}

/// Writes bytes that are already in memory; see [`write_atomically`].
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Outcome {
    write_atomically(path, |file| file.write_all(bytes))
}

fn write_beside<W>(target: &Path, fill: W) -> io::Result<()>
where
    W: FnOnce(&mut BufWriter<File>) -> io::Result<()>,
{
    let temporary = temporary_beside(target)?;
    fill_and_flush(temporary.as_file().try_clone()?, fill)?;
    temporary.persist(target).map_err(|error| error.error)?;
    Ok(())
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
        let failed = write_atomically(&path, |file| {
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
