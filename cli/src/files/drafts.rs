//! Outputs that appear whole or not at all.
//!
//! Each output is written to a temporary file in its own folder. [`Drafts::publish`] renames them all once the last one
//! is complete, so a failure or Ctrl-C before that leaves every path as it was. A symbolic link stays a link: the file
//! that it points to is replaced, or made. What is no regular file (a pipe, `/dev/null`, `-`) is written in place, at publishing.
//! Limits: the renames of several outputs are one after the other; a power cut between two leaves the first.

use super::paths::{is_stdout, same_file};
use crate::base::failure::Failure;
use std::fs::{self, File, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;
use tempfile::{Builder, NamedTempFile};

/// Links that are followed, as many as Linux does.
const LINKS: usize = 40;

/// Complete outputs that nobody sees yet.
#[derive(Default)]
pub struct Drafts {
    drafts: Vec<Draft>,
}

struct Draft {
    flag: &'static str,
    path: PathBuf,
    text: Text,
}

enum Text {
    Beside(NamedTempFile),
    InPlace(Vec<u8>),
}

/// Finds out, before the work, whether `path` can be written: a temporary file is made in its folder and removed.
/// `flag` is what the message names.
pub fn check(flag: &'static str, path: &Path) -> Result<(), Failure> {
    match place(path) {
        Ok(Place::Beside(target)) => temporary(&target).map(drop),
        Ok(Place::InPlace) => Ok(()),
        Err(e) => Err(e),
    }
    .map_err(|e| Failure::output(flag, path, &e))
}

impl Drafts {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// [`add`](Self::add), in a folder that is made where it is missing.
    pub fn add_below(
        &mut self,
        flag: &'static str,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let folder = path.parent().unwrap_or(Path::new(""));
        if !folder.as_os_str().is_empty() {
            fs::create_dir_all(folder).map_err(|e| Failure::output(flag, path, &e))?;
        }
        self.add(flag, path, write)
    }

    /// Writes one output in full by `write`; nothing shows at `path` before [`publish`](Self::publish).
    pub fn add(
        &mut self,
        flag: &'static str,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let draft = || -> io::Result<Draft> {
            match place(path)? {
                Place::Beside(target) => {
                    let mut out = BufWriter::with_capacity(1 << 16, temporary(&target)?);
                    write(&mut out)?;
                    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
                    file.as_file().sync_all()?;
                    Ok(Draft { flag, path: target, text: Text::Beside(file) })
                }
                Place::InPlace => {
                    let mut out = Vec::new();
                    write(&mut out)?;
                    Ok(Draft { flag, path: path.to_path_buf(), text: Text::InPlace(out) })
                }
            }
        };
        let draft = draft().map_err(|e| Failure::output(flag, path, &e))?;
        if let Some(other) = self.drafts.iter().find(|other| same_file(&other.path, &draft.path)) {
            let text =
                format!("{flag} {}: the same file as one that {} writes; choose another", path.display(), other.flag);
            return Err(Failure::Usage(text));
        }
        self.drafts.push(draft);
        Ok(())
    }

    /// Puts every output in its place: what is written in place first, since that may fail where a rename does not.
    pub fn publish(mut self) -> Result<(), Failure> {
        let mut known = known();
        known.are_published = !self.drafts.is_empty();
        self.drafts.sort_by_key(|draft| matches!(draft.text, Text::Beside(_)));
        for Draft { flag, path, text } in self.drafts {
            match text {
                Text::Beside(file) => file.persist(&path).map(drop).map_err(|e| e.error),
                Text::InPlace(bytes) if is_stdout(&path) => {
                    let mut out = io::stdout().lock();
                    out.write_all(&bytes).and_then(|()| out.flush())
                }
                Text::InPlace(bytes) => File::create(&path).and_then(|mut file| file.write_all(&bytes)),
            }
            .map_err(|e| Failure::output(flag, &path, &e))?;
        }
        Ok(())
    }
}

/// How a path is written.
enum Place {
    /// By renaming a file over it; links are followed.
    Beside(PathBuf),
    /// By opening it.
    InPlace,
}

fn place(path: &Path) -> io::Result<Place> {
    match fs::metadata(path) {
        _ if is_stdout(path) => Ok(Place::InPlace),
        Ok(data) if data.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(data) if data.is_file() && data.permissions().readonly() => Err(io::ErrorKind::PermissionDenied.into()),
        Ok(data) if data.is_file() => fs::canonicalize(path).map(Place::Beside),
        Ok(_) => Ok(Place::InPlace),
        Err(e) if e.kind() == io::ErrorKind::NotFound => end_of_links(path).map(Place::Beside),
        Err(e) => Err(e),
    }
}

/// Where a path leads that nothing lies at: itself, or what its links point to.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut end = path.to_path_buf();
    for _ in 0..LINKS {
        match fs::read_link(&end) {
            Ok(next) => end = end.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(end),
        }
    }
    Err(io::Error::other("its links lead round in a circle"))
}

/// An empty file in the folder of `target`, with the permissions that `target` has or would get.
fn temporary(target: &Path) -> io::Result<NamedTempFile> {
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = Builder::new();
    builder.prefix(".seamwright-").suffix(".tmp");
    let permissions = fs::metadata(target).map(|data| data.permissions()).ok().or_else(usual_permissions);
    if let Some(permissions) = permissions {
        builder.permissions(permissions);
    }
    // Named in the lock, so that whoever abandons all drafts knows of it.
    let mut named = known();
    let file = builder.tempfile_in(folder)?;
    named.drafts.push(file.path().to_path_buf());
    Ok(file)
}

/// The drafts of this process.
struct Known {
    drafts: Vec<PathBuf>,
    are_published: bool,
}

static KNOWN: Mutex<Known> = Mutex::new(Known { drafts: Vec::new(), are_published: false });

fn known() -> MutexGuard<'static, Known> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all drafts, after which none can be made or published: for a process that is about to end. False where outputs are in their
/// places already. Does not wait long for a reader of what is written in place.
pub fn abandon() -> bool {
    for _ in 0..20 {
        if let Ok(known) = KNOWN.try_lock() {
            if known.are_published {
                return false;
            }
            for draft in &known.drafts {
                // Most are gone, with what made them.
                let _ = fs::remove_file(draft);
            }
            std::mem::forget(known);
            return true;
        }
        thread::sleep(Duration::from_millis(2));
    }
    true
}

/// What a new file gets before the user's mask.
#[cfg(unix)]
fn usual_permissions() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn usual_permissions() -> Option<Permissions> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn nothing_shows_before_publishing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        fs::write(&path, "old").unwrap();
        let mut drafts = Drafts::new();
        drafts.add("-o", &path, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drafts.publish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn a_failed_write_leaves_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let mut drafts = Drafts::new();
        let failed = drafts.add("-o", &path, |out| {
            out.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.map_err(|e| e.code()), Err(4));
        assert_eq!(entries(folder.path()), 0);
    }

    #[test]
    fn a_folder_that_is_missing_or_in_the_way_is_refused_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(check("-o", folder.path()).map_err(|e| e.code()), Err(4));
        assert_eq!(check("-o", &folder.path().join("no/a.obj")).map_err(|e| e.code()), Err(4));
        assert_eq!(check("-o", &folder.path().join("a.obj")), Ok(()));
        assert_eq!(entries(folder.path()), 0);
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a.obj"), folder.path().join("b.obj"));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        let mut drafts = Drafts::new();
        drafts.add("-o", &link, |out| out.write_all(b"new")).unwrap();
        drafts.publish().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        // One that leads nowhere makes the file that it names.
        fs::create_dir(folder.path().join("far")).unwrap();
        let (first, second) = (folder.path().join("c.obj"), folder.path().join("d.obj"));
        symlink("d.obj", &first).unwrap();
        symlink("far/e.obj", &second).unwrap();
        assert_eq!(check("-o", &first), Ok(()));
        let mut drafts = Drafts::new();
        drafts.add("-o", &first, |out| out.write_all(b"far")).unwrap();
        drafts.publish().unwrap();
        assert!([first, second].iter().all(|link| fs::symlink_metadata(link).unwrap().is_symlink()));
        assert_eq!(fs::read(folder.path().join("far/e.obj")).unwrap(), b"far");
        let round = folder.path().join("r.obj");
        symlink("r.obj", &round).unwrap();
        assert_eq!(check("-o", &round).map_err(|e| e.code()), Err(4));
    }
}
